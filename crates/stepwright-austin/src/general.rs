//! Constant acceleration by Eq 12–15, with a deceleration of its own.
//!
//! ```text
//!   up    c(n) = c(n−1) − 2·c(n−1) / (4n + 1)       n = 1 … N     Eq 12
//!   down  c    = c      + 2·c      / (4j − 1)       j = J … 2     Eq 14, n = −j
//!   J + ½ = (N + ½)·a/d                                           Eq 18
//!   N ≈ m·d / (a + d) − 1  when the top speed is out of reach      Eq 19
//! ```
//!
//! J is rounded to nearest; the remainder of m pulses is travelled at the speed reached. On
//! reaching c_min the delay is kept there; the way down starts from the delay that was cut short,
//! like the end of the way up.
//!
//! On the way up another acceleration may be set (Eq 18: n₂ + ½ = (n₁ + ½)·a₁/a₂); the divisor is
//! 4n₂ + 1 from there on, to 2⁻¹⁶.
//!
//! The variant with c/2n instead of 2c/(4n+1): c₀ is √π/2 (88.6 %) of the exact one, the half step
//! of Eq 18 is a quarter, and the way down has another equation:
//!
//! ```text
//!   up    c(n) = c(n−1) − c(n−1) / 2n               c₀·0.886
//!   down  c    = c      + c      / (2j − 1)
//! ```
//!
//! Error against the formulas in f64: each delay below one tick, the time of each pulse half a tick
//! (0.50 measured over 100,000 steps). After a change the divisor's 2⁻¹⁶ shifts c by 2⁻¹⁶/(4n+1)²
//! of itself per step: all that follows is up to 2.2·10⁻⁶ of the time off if the change comes after
//! the first step (1.1·10⁻⁶ measured). Against constant acceleration: `docs/laws.md`.

use super::count::{C0, Order, Pulses};
use super::travel::{Slopes, Travel};
use crate::share::{mul_div, share};
use stepwright::fixed::Q32;
use stepwright::profile::Unfit;
use stepwright::units::{Accel, Rate, Speed};

/// The divisor of the change in each step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Divisor {
    /// 2c/(4n+1), Eq 12: the same up and down.
    #[default]
    FourN,
    /// c/2n: c₀ at √π/2 of the exact one.
    TwoN,
}

/// One step in the units of n if n is not whole, and the largest n: 2³³ steps.
const STEP: u64 = 1 << 28;
const LARGEST: u64 = STEP << 33;

/// √π/2 in 2⁻³².
const HALF_ROOT_PI: u64 = 3_806_315_662;

/// A travel with Austin's ramps.
///
/// ```
/// use stepwright_austin::{Austin, C0};
/// use stepwright::{Accel, Rate, Speed};
/// // 1 MHz, 400 steps/s², 400 steps/s: Figures 2 to 4.
/// let law = Austin::new(Rate::MHZ, Speed::from_steps(400)?, Accel::from_steps(400)?);
/// let delays: Vec<u32> = law.delays(1000)?.collect();
/// assert_eq!(delays[..3], [0, 47_800, 28_681]);
/// assert_eq!(delays[500], 2_500);
/// let exact = law.with_c0(C0::FirstStep).delays(1000)?;
/// assert_eq!(exact.take(3).collect::<Vec<_>>(), [0, 70_711, 28_680]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Austin {
    order: Order,
    divisor: Divisor,
}

impl Austin {
    /// From rest at `accel` to `top`, and back to rest at the same rate.
    pub const fn new(rate: Rate, top: Speed, accel: Accel) -> Austin {
        Austin { order: Order::new(rate, top, accel), divisor: Divisor::FourN }
    }

    /// This travel with another deceleration.
    pub const fn with_decel(mut self, decel: Accel) -> Austin {
        self.order.decel = decel;
        self
    }

    /// This travel with another way to begin.
    pub const fn with_c0(mut self, c0: C0) -> Austin {
        self.order.c0 = c0;
        self
    }

    /// This travel with another divisor: c/2n has its own c₀.
    pub const fn with_divisor(mut self, divisor: Divisor) -> Austin {
        self.divisor = divisor;
        self
    }

    /// The delay before each of `pulses` pulses; the first is 0.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn delays(&self, pulses: u32) -> Result<Pulses<Travel<Ramps>>, Unfit> {
        Ok(self.constants(pulses)?.delays(pulses))
    }

    /// The constants that the steps of a travel of `pulses` pulses need.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn constants(&self, pulses: u32) -> Result<RampConstants, Unfit> {
        let order = self.order.fitted(pulses)?;
        let exact = order.exact(order.accel);
        let (lead, count) = match self.divisor {
            Divisor::FourN => order.c0.counts(exact),
            Divisor::TwoN => {
                let count = share(exact, HALF_ROOT_PI, 1 << 32);
                (count, count)
            }
        };
        let (accel, decel, divisor) = (order.accel, order.decel, self.divisor);
        Ok(RampConstants { lead, count, shortest: order.shortest(), accel, decel, divisor })
    }
}

/// The constants of a travel with constant acceleration: delays in 2⁻³² ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RampConstants {
    /// The first delay.
    pub lead: Q32,
    /// The delay from which the formula continues.
    pub count: Q32,
    /// c_min.
    pub shortest: Q32,
    /// Acceleration.
    pub accel: Accel,
    /// Deceleration.
    pub decel: Accel,
    /// The divisor of the change in each step.
    pub divisor: Divisor,
}

impl RampConstants {
    /// The delay before each of `pulses` pulses; the first is 0.
    pub fn delays(&self, pulses: u32) -> Pulses<Travel<Ramps>> {
        let RampConstants { lead, count, shortest, accel, decel, divisor } = *self;
        let (accel, decel) = (accel.millisteps(), decel.millisteps());
        let place = Place::Whole(0);
        let mut ramps = Ramps { count, shortest, accel, decel, divisor, place, room: 0 };
        ramps.room = ramps.room(pulses.saturating_sub(1));
        Pulses::new(Travel::new(ramps), lead, shortest, pulses)
    }
}

/// n: the place on a ramp, from rest at its present acceleration.
#[derive(Clone, Copy, Debug)]
enum Place {
    /// n.
    Whole(u32),
    /// n + ½ in 2⁻²⁸ steps, after a change of acceleration (Eq 18).
    Between(u64),
}

/// Both ramps of a travel.
#[derive(Clone, Debug)]
pub struct Ramps {
    count: Q32,
    shortest: Q32,
    /// a and d, in thousandths.
    accel: u64,
    decel: u64,
    divisor: Divisor,
    place: Place,
    /// The number of steps up for which there is still room.
    room: u32,
}

impl Ramps {
    /// J after `more` further steps up: Eq 18, rounded to nearest.
    fn steps_down(&self, more: u32) -> u32 {
        let (a, d) = (self.accel, self.decel);
        let steps = match (self.divisor, self.place) {
            // (n + ½)·a/d − ½ + ½
            (Divisor::FourN, Place::Whole(n)) => {
                mul_div(2 * (u64::from(n) + u64::from(more)) + 1, a, 2 * d).0
            }
            (Divisor::FourN, Place::Between(far)) => {
                mul_div(far + u64::from(more) * STEP, a, d).0 / STEP
            }
            // (n + ¼)·a/d − ¼ + ½
            (Divisor::TwoN, Place::Whole(n)) => {
                let n = u64::from(n) + u64::from(more);
                let (q, rest) = mul_div(4 * n + 1, a, 4 * d);
                q.saturating_add(u64::from(rest >= 3 * d))
            }
            // There are no changes with this divisor.
            (Divisor::TwoN, Place::Between(_)) => 0,
        };
        u32::try_from(steps).unwrap_or(u32::MAX)
    }

    /// The number of steps up for which there is room, where the next is the first of `left` delays
    /// but one: k + J(k) ≤ left, which is Eq 19 for a ramp from rest.
    fn room(&self, left: u32) -> u32 {
        let (m, sum) = (u64::from(left) + 1, self.accel + self.decel);
        let most = mul_div(m, self.decel, sum).0;
        let most = most.saturating_sub(mul_div(self.far(), self.accel, sum).0 / STEP);
        let mut room = most.min(left.into()) as u32;
        while room > 0 && u64::from(room) + u64::from(self.steps_down(room)) > left.into() {
            room -= 1;
        }
        room
    }

    /// n + ½ in 2⁻²⁸ steps.
    fn far(&self) -> u64 {
        match self.place {
            Place::Whole(n) => (2 * u64::from(n) + 1) * (STEP / 2),
            Place::Between(far) => far,
        }
    }

    /// Sets another acceleration from here on: Eq 18. The next step up is the first of `left`
    /// delays but one. Returns false and does nothing with the divisor 2n.
    fn set_accel(&mut self, accel: Accel, left: u32) -> bool {
        if self.divisor == Divisor::TwoN {
            return false;
        }
        let to = accel.millisteps();
        if to != self.accel {
            self.place = Place::Between(share(self.far(), self.accel, to).min(LARGEST));
            self.accel = to;
        }
        self.room = self.room(left);
        true
    }
}

impl Pulses<Travel<Ramps>> {
    /// Sets another acceleration from the next delay on: Eq 18. Returns false and does nothing
    /// after the end of the way up, and with [`Divisor::TwoN`].
    ///
    /// ```
    /// use stepwright_austin::Austin;
    /// use stepwright::{Accel, Rate, Speed};
    /// let a = |n| Accel::from_steps(n).unwrap();
    /// let mut delays = Austin::new(Rate::MHZ, Speed::from_steps(400)?, a(200)).delays(1000)?;
    /// let slow: Vec<u32> = delays.by_ref().take(101).collect();
    /// assert!(delays.set_accel(a(400)));
    /// // 200 steps/s², and from 200 steps/s on 400.
    /// assert_eq!((slow[100], delays.next()), (5_013, Some(4_963)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_accel(&mut self, accel: Accel) -> bool {
        let (travel, left) = self.law();
        travel.rising().is_some_and(|ramps| ramps.set_accel(accel, left))
    }
}

impl Slopes for Ramps {
    #[inline]
    fn faster(&mut self, _left: u32) -> bool {
        if self.room == 0 || self.count <= self.shortest {
            return false;
        }
        self.room -= 1;
        self.count -= match (&mut self.place, self.divisor) {
            (Place::Whole(n), Divisor::FourN) => {
                *n += 1;
                share(self.count, 2, 4 * u64::from(*n) + 1)
            }
            (Place::Whole(n), Divisor::TwoN) => {
                *n += 1;
                share(self.count, 1, 2 * u64::from(*n))
            }
            (Place::Between(far), _) => {
                *far = (*far + STEP).min(LARGEST);
                // 4n + 1 in 2⁻¹⁶: more digits do not change a delay, and the product is slow.
                share(self.count, 2 << 16, (4 * *far - STEP + (1 << 11)) >> 12)
            }
        };
        true
    }

    #[inline]
    fn slower(&mut self, j: u32) {
        let j = u64::from(j).max(1);
        let more = match self.divisor {
            Divisor::FourN => share(self.count, 2, 4 * j - 1),
            Divisor::TwoN => share(self.count, 1, 2 * j - 1),
        };
        self.count = self.count.saturating_add(more);
    }

    fn braking(&self) -> u32 {
        self.steps_down(0)
    }

    fn count(&self) -> Q32 {
        self.count
    }
}
