//! Acceleration reduced in stages (Austin, Figure 5).
//!
//! ```text
//!   break b     c ≤ c_min·(1 + 2^(1−b))            b = 1 … B: 2, 1.5, 1.25 … times c_min
//!   step i      n(i) = n(i−1) + 1
//!               n(i) = 1.375·(n(i−1) + 1)          if c(i−1) crossed a break
//!               c(i) = c(i−1) − 2·c(i−1) / (4·n(i) + 1)
//! ```
//!
//! By Eq 17 each break divides the acceleration by 1.375; seven breaks leave a ninth of it. The way
//! down takes the steps of a ramp with the deceleration in reverse. Several breaks in one step
//! multiply n once each.
//!
//! n is stored in 2⁻²⁸ steps. Error against the formulas in f64: each delay below one tick.

use super::count::{C0, Order, Pulses};
use super::travel::{Curve, Shadowed, Travel};
use crate::share::share;
use stepwright::fixed::{Q32, shr};
use stepwright::profile::Unfit;
use stepwright::units::{Accel, Rate, Speed};

/// The most breaks: the sixteenth is 2⁻¹⁵ below the top speed.
pub const MOST_BREAKS: u8 = 16;

/// One step, in the units of n.
const STEP: u64 = 1 << 28;
/// Larger n make no difference any more, and this value can be multiplied.
const LARGEST: u64 = STEP << 33;

/// A travel whose acceleration is reduced in stages near the top speed.
///
/// ```
/// use stepwright_austin::Piecewise;
/// use stepwright::{Accel, Rate, Speed};
/// let law = Piecewise::new(Rate::MHZ, Speed::from_steps(400)?, Accel::from_steps(400)?);
/// assert_eq!(law.delays(2000)?.count(), 2000);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piecewise {
    order: Order,
    breaks: u8,
}

impl Piecewise {
    /// From rest to `top`, initially at `accel`, and back to rest; 7 breaks, as in Figure 5.
    pub const fn new(rate: Rate, top: Speed, accel: Accel) -> Piecewise {
        Piecewise { order: Order::new(rate, top, accel), breaks: 7 }
    }

    /// This travel with another deceleration.
    pub const fn with_decel(mut self, decel: Accel) -> Piecewise {
        self.order.decel = decel;
        self
    }

    /// This travel with another way to begin.
    pub const fn with_c0(mut self, c0: C0) -> Piecewise {
        self.order.c0 = c0;
        self
    }

    /// This travel with this many breaks, at most [`MOST_BREAKS`]; 0 is constant acceleration.
    pub const fn with_breaks(mut self, breaks: u8) -> Piecewise {
        self.breaks = if breaks > MOST_BREAKS { MOST_BREAKS } else { breaks };
        self
    }

    /// The delay before each of `pulses` pulses; the first is 0.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn delays(&self, pulses: u32) -> Result<Pulses<Travel<Shadowed<Stages>>>, Unfit> {
        Ok(self.constants(pulses)?.delays(pulses))
    }

    /// The constants that the steps of a travel of `pulses` pulses need.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn constants(&self, pulses: u32) -> Result<StageConstants, Unfit> {
        let order = self.order.fitted(pulses)?;
        let (lead, rise) = order.c0.counts(order.exact(order.accel));
        let (_, fall) = order.c0.counts(order.exact(order.decel));
        Ok(StageConstants { lead, shortest: order.shortest(), rise, fall, breaks: self.breaks })
    }
}

/// The constants of a piecewise travel: delays in 2⁻³² ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageConstants {
    /// The first delay.
    pub lead: Q32,
    /// c_min.
    pub shortest: Q32,
    /// The delay from which the way up continues.
    pub rise: Q32,
    /// The same for the way down, as a ramp from rest.
    pub fall: Q32,
    /// The number of breaks, at most [`MOST_BREAKS`].
    pub breaks: u8,
}

impl StageConstants {
    /// The delay before each of `pulses` pulses; the first is 0.
    pub fn delays(&self, pulses: u32) -> Pulses<Travel<Shadowed<Stages>>> {
        let StageConstants { lead, shortest, rise, fall, breaks } = *self;
        let stages = |count| Stages {
            count,
            shortest,
            n: 0,
            steps: 0,
            breaks,
            crossed: 0,
            at: [0; MOST_BREAKS as usize],
        };
        let travel = Travel::new(Shadowed::new(stages(rise), stages(fall), shortest));
        Pulses::new(travel, lead, shortest, pulses)
    }
}

/// A ramp from rest with its breaks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stages {
    count: Q32,
    shortest: Q32,
    /// n in 2⁻²⁸ steps.
    n: u64,
    steps: u32,
    breaks: u8,
    /// The number of breaks so far, and the steps at which they came, for the way back.
    crossed: u8,
    at: [u32; MOST_BREAKS as usize],
}

impl Stages {
    /// The delay of break b, b = 1 … B.
    fn threshold(&self, b: u8) -> Q32 {
        self.shortest.saturating_add(shr(self.shortest, b.saturating_sub(1)))
    }
}

/// The divisor 4n ± 1 for n in 2⁻²⁸ steps, and its dividend, in lowest terms.
pub(crate) fn divisor(fine: u64) -> (u64, u64) {
    let by = (fine.trailing_zeros() as u8).min(28);
    (2 * shr(STEP, by), shr(fine, by))
}

impl Curve for Stages {
    fn up(&mut self) {
        self.steps = self.steps.saturating_add(1);
        self.n = (self.n + STEP).min(LARGEST);
        while self.crossed < self.breaks && self.count <= self.threshold(self.crossed + 1) {
            if let Some(at) = self.at.get_mut(usize::from(self.crossed)) {
                *at = self.steps;
            }
            self.crossed += 1;
            self.n = (self.n + self.n / 4 + self.n / 8).min(LARGEST); // 1.375
        }
        let (n, d) = divisor(4 * self.n + STEP);
        self.count -= share(self.count, n, d);
    }

    fn down(&mut self) -> (u64, u64) {
        let change = divisor((4 * self.n).saturating_sub(STEP));
        while let Some(b) = self.crossed.checked_sub(1)
            && self.at.get(usize::from(b)) == Some(&self.steps)
        {
            self.crossed = b;
            self.n = share(self.n, 8, 11);
        }
        self.n = self.n.saturating_sub(STEP).max(STEP);
        self.steps = self.steps.saturating_sub(1);
        change
    }

    fn steps(&self) -> u32 {
        self.steps
    }

    fn count(&self) -> Q32 {
        self.count
    }
}
