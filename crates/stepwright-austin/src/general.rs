//! Constant acceleration by Eq 12–15, with a deceleration of its own.
//!
//! ```text
//!   up    c(n) = c(n−1) − 2·c(n−1) / (4n + 1)       n = 1 … N     Eq 12
//!   down  c    = c      + 2·c      / (4j − 1)       j = J … 2     Eq 14, n = −j
//!   J + ½ = (N + ½)·a/d                                           Eq 18
//!   N ≈ m·d / (a + d) − 1  when the top speed is out of reach      Eq 19
//! ```
//!
//! J is rounded to the nearest; what rounding leaves over of m pulses is
//! travelled at the speed reached. On reaching c_min the delay is held there;
//! down it goes from the delay that was cut short, as the way up came.
//!
//! The variant with c/2n instead of 2c/(4n+1): c₀ is √π/2 (88.6 %) of the exact
//! one, the half step of Eq 18 a quarter, and down is another equation:
//!
//! ```text
//!   up    c(n) = c(n−1) − c(n−1) / 2n               c₀·0.886
//!   down  c    = c      + c      / (2j − 1)
//! ```
//!
//! Error against the formulas in f64: each delay below one tick, each pulse's
//! time half a tick (0.50 measured over 100,000 steps). Against constant
//! acceleration: `docs/laws.md`.

use super::count::{C0, Order, Pulses};
use super::travel::{Slopes, Travel};
use crate::share::{mul_div, share};
use stepwright::fixed::Q32;
use stepwright::profile::Unfit;
use stepwright::units::{Accel, Rate, Speed};

/// What the change of a step is divided by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Divisor {
    /// 2c/(4n+1), Eq 12: the same up and down.
    #[default]
    FourN,
    /// c/2n: c₀ at √π/2 of the exact one.
    TwoN,
}

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

    /// The same with a deceleration of its own.
    pub const fn with_decel(mut self, decel: Accel) -> Austin {
        self.order.decel = decel;
        self
    }

    /// The same with another way to begin.
    pub const fn with_c0(mut self, c0: C0) -> Austin {
        self.order.c0 = c0;
        self
    }

    /// The variant with c/2n, whose c₀ is its own.
    pub const fn with_divisor(mut self, divisor: Divisor) -> Austin {
        self.divisor = divisor;
        self
    }

    /// The delay before each of `pulses` pulses; the first is 0.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't hold it.
    pub fn delays(&self, pulses: u32) -> Result<Pulses<Travel<Ramps>>, Unfit> {
        let order = self.order.fitted(pulses)?;
        let exact = order.exact(order.accel);
        let (lead, count) = match self.divisor {
            Divisor::FourN => order.c0.counts(exact),
            Divisor::TwoN => {
                let count = share(exact, HALF_ROOT_PI, 1 << 32);
                (count, count)
            }
        };
        let mut ramps = Ramps {
            count,
            shortest: order.shortest(),
            accel: order.accel.millisteps(),
            decel: order.decel.millisteps(),
            divisor: self.divisor,
            n: 0,
            turn: 0,
        };
        ramps.turn = ramps.turn(pulses);
        let shortest = ramps.shortest;
        Ok(Pulses::new(Travel::new(ramps), lead, shortest, pulses))
    }
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
    /// Steps up so far.
    n: u32,
    /// The last step up for which there is room.
    turn: u32,
}

impl Ramps {
    /// J for N = n: Eq 18, to the nearest.
    fn steps_down(&self, n: u32) -> u32 {
        let (a, d, n) = (self.accel, self.decel, u64::from(n));
        let steps = match self.divisor {
            // (n + ½)·a/d − ½ + ½
            Divisor::FourN => mul_div(2 * n + 1, a, 2 * d).0,
            // (n + ¼)·a/d − ¼ + ½
            Divisor::TwoN => {
                let (q, rest) = mul_div(4 * n + 1, a, 4 * d);
                q.saturating_add(u64::from(rest >= 3 * d))
            }
        };
        u32::try_from(steps).unwrap_or(u32::MAX)
    }

    /// Eq 19: the last step up of a travel of `pulses`.
    fn turn(&self, pulses: u32) -> u32 {
        let m = u64::from(pulses);
        let (most, _) = mul_div(m, self.decel, self.accel + self.decel);
        let mut turn = most as u32; // at most m
        while turn > 0 && u64::from(turn) + 1 + u64::from(self.steps_down(turn)) > m {
            turn -= 1;
        }
        turn
    }
}

impl Slopes for Ramps {
    #[inline]
    fn faster(&mut self, _left: u32) -> bool {
        if self.n >= self.turn || self.count <= self.shortest {
            return false;
        }
        self.n += 1;
        let n = u64::from(self.n);
        self.count -= match self.divisor {
            Divisor::FourN => share(self.count, 2, 4 * n + 1),
            Divisor::TwoN => share(self.count, 1, 2 * n),
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
        self.steps_down(self.n)
    }

    fn count(&self) -> Q32 {
        self.count
    }
}
