//! The change scaled by a linear factor (Austin, Eq 22–25).
//!
//! ```text
//!   up    c(n) = c(n−1) − 2·c(n−1)/(4n + 1) · (n₂ − n)/(n₂ − n₁)       n₁ ≤ n ≤ n₂
//!   down  c    = c      + 2·c     /(4j − 1) · (j₂ − j)/(j₂ − j₁)       j₁ ≤ j ≤ j₂
//! ```
//!
//! j = m − i is the number of steps before the end, with j₁ = 1 and j₂ = m − n₃ in Eq 25; before n₁
//! and after j₁ the factor is 1. The acceleration falls from a at the knee n₁ to 0 at n₂, where the
//! top speed v is reached. This gives n₁ = k²·v²/2a for a knee at k·v (Eq 16), and n₂:
//!
//! ```text
//!   v² = (2/e)·a·(n₁ + ½)·((n₂ + ½)/(n₁ + ½))^(n₂/(n₂ − n₁))          Eq 23
//!   n₂ = ⌊v² / 0.736·a⌋                                  n₁ = 0       Eq 24
//! ```
//!
//! If the two ramps do not fit in m pulses, they meet at n₂ = n₃ = m·d/(a + d) (Eq 19), and the
//! knees move in the same proportion: the change from acceleration to deceleration has no jump.
//!
//! Eq 23 is an estimate: the speed reached is 0 to 0.2 % below the top speed for ramps of 100 steps
//! and more, and up to 4 % below for ten. Where it would be above, the delay stays that of the top
//! speed. Error against the formulas in f64: each delay below one tick.

use super::count::{C0, Law, Order, Pulses};
use crate::share::{log2, mul_div, share};
use stepwright::fixed::Q32;
use stepwright::profile::{Phase, Unfit, slope_of};
use stepwright::units::{Accel, Rate, Speed};

/// log₂ e in 2⁻⁴⁸.
const LOG2_E: u64 = 406_082_553_034_800;

/// A travel whose acceleration falls linearly near the top speed.
///
/// ```
/// use stepwright_austin::LinearFactor;
/// use stepwright::{Accel, Rate, Speed};
/// // Figure 8: 10 rad/s at 10 and −20 rad/s², 1.8°, 700 steps.
/// let a = |n| Accel::from_millisteps(n).unwrap();
/// let law = LinearFactor::new(Rate::MHZ, Speed::from_millisteps(318_310)?, a(318_310))
///     .with_decel(a(636_620));
/// let corners = law.corners(700)?;
/// assert_eq!((corners.n2, corners.n3(700)), (432, 484));
/// let corners = law.corners(500)?;
/// assert_eq!((corners.n2, corners.n3(500)), (333, 333));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinearFactor {
    order: Order,
    knee: u16,
}

/// The beginning and the end of the factor, in steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corners {
    /// Up: the factor falls from 1 here …
    pub n1: u32,
    /// … to 0 here.
    pub n2: u32,
    /// Down, counted from the end: the factor rises to 1 here …
    pub j1: u32,
    /// … from 0 here.
    pub j2: u32,
}

impl Corners {
    /// The step at which the way down of `pulses` pulses begins.
    pub const fn n3(&self, pulses: u32) -> u32 {
        pulses.saturating_sub(self.j2)
    }
}

impl LinearFactor {
    /// From rest to `top`, initially at `accel`, and back to rest; the factor begins at once.
    pub const fn new(rate: Rate, top: Speed, accel: Accel) -> LinearFactor {
        LinearFactor { order: Order::new(rate, top, accel), knee: 0 }
    }

    /// This travel with another deceleration.
    pub const fn with_decel(mut self, decel: Accel) -> LinearFactor {
        self.order.decel = decel;
        self
    }

    /// This travel with another way to begin.
    pub const fn with_c0(mut self, c0: C0) -> LinearFactor {
        self.order.c0 = c0;
        self
    }

    /// This travel with the factor beginning at `knee` thousandths of the top speed, at most 900.
    pub const fn with_knee(mut self, knee: u16) -> LinearFactor {
        self.knee = if knee > 900 { 900 } else { knee };
        self
    }

    /// The beginning and the end of the factor for this many pulses.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn corners(&self, pulses: u32) -> Result<Corners, Unfit> {
        Ok(self.fit(&self.order.fitted(pulses)?, pulses))
    }

    fn fit(&self, order: &Order, pulses: u32) -> Corners {
        let (up, down) = (self.transition(order.accel), self.transition(order.decel));
        let (a, d) = (order.accel.millisteps(), order.decel.millisteps());
        let m = u64::from(pulses);
        if u64::from(up.1) + u64::from(down.1) <= m || m < 2 {
            return Corners { n1: up.0, n2: up.1, j1: down.0.max(1), j2: down.1 };
        }
        let n2 = share(m, d, a + d).clamp(1, m - 1) as u32; // m is at most 2³¹
        let j2 = pulses - n2;
        let scaled = |(n1, n2): (u32, u32), short: u32| {
            share(n1.into(), short.into(), n2.into()).min(u64::from(short) - 1) as u32
        };
        Corners { n1: scaled(up, n2), n2, j1: scaled(down, j2).max(1), j2 }
    }

    /// n₁ and n₂ of a ramp to the top speed.
    fn transition(&self, accel: Accel) -> (u32, u32) {
        // At least 2000; the compiler can't know.
        let (w, slope) = (self.order.top.squared(), slope_of(accel).max(1));
        // The ramp actually has p/q of its acceleration.
        let (p, q) = self.order.c0.part();
        let knee = u64::from(self.knee);
        let n1 = share(mul_div(w, knee * knee * q, p * 1_000_000).0, 1, slope);
        let n1 = n1.min(1 << 31) as u32;
        if n1 == 0 {
            let n2 = mul_div(w, 2_000 * q, 736 * p).0 / slope;
            return (0, n2.clamp(1, u32::MAX.into()) as u32);
        }
        // log₂ of e·v² / (2a·(n₁ + ½)); v² ≥ 2a·n₁ makes it more than 0.
        let odd = 2 * u64::from(n1) + 1;
        let above = LOG2_E + (1 << 48) + log2(w) + log2(q);
        let reach = above.saturating_sub(log2(slope) + log2(p) + log2(odd));
        // Grows with n₂: searches the last value that does not exceed the top speed.
        let fits = |n2: u64| {
            let ratio = log2(2 * n2 + 1) - log2(odd);
            mul_div(ratio, n2, n2 - u64::from(n1)).0 <= reach
        };
        let (mut low, mut high) = (u64::from(n1) + 1, u64::from(u32::MAX));
        while low + 1 < high {
            let middle = (low + high) / 2;
            if fits(middle) { low = middle } else { high = middle }
        }
        (n1, low as u32)
    }

    /// The delay before each of `pulses` pulses; the first is 0.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn delays(&self, pulses: u32) -> Result<Pulses<Factor>, Unfit> {
        Ok(self.constants(pulses)?.delays(pulses))
    }

    /// The constants that the steps of a travel of `pulses` pulses need.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn constants(&self, pulses: u32) -> Result<FactorConstants, Unfit> {
        let order = self.order.fitted(pulses)?;
        let (lead, count) = order.c0.counts(order.exact(order.accel));
        let corners = self.fit(&order, pulses);
        Ok(FactorConstants { lead, count, shortest: order.shortest(), corners })
    }
}

/// The constants of a travel with linear factors: delays in 2⁻³² ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FactorConstants {
    /// The first delay.
    pub lead: Q32,
    /// The delay from which the formula continues.
    pub count: Q32,
    /// c_min.
    pub shortest: Q32,
    /// The beginning and the end of the factor.
    pub corners: Corners,
}

impl FactorConstants {
    /// The delay before each of `pulses` pulses; the first is 0.
    pub fn delays(&self, pulses: u32) -> Pulses<Factor> {
        let FactorConstants { lead, count, shortest, corners } = *self;
        Pulses::new(Factor { count, corners, n: 0 }, lead, shortest, pulses)
    }
}

/// Both ramps of a travel with linear factors.
#[derive(Clone, Debug)]
pub struct Factor {
    count: Q32,
    corners: Corners,
    /// The number of steps up so far.
    n: u32,
}

impl Law for Factor {
    #[inline]
    fn advance(&mut self, left: u32) -> Phase {
        let Corners { n1, n2, j1, j2 } = self.corners;
        let j = left.saturating_add(1); // the hold after the last pulse is j = 1
        if j > j2 {
            if self.n >= n2 {
                return Phase::Cruise;
            }
            self.n += 1;
            let n = self.n.max(n1);
            let divisor = (4 * u64::from(self.n) + 1) * u64::from(n2 - n1);
            self.count -= share(self.count, 2 * u64::from(n2 - n), divisor);
            Phase::Up
        } else {
            let rest = j.max(j1);
            let span = u64::from(j2.saturating_sub(j1)).max(1);
            let divisor = (4 * u64::from(j) - 1) * span;
            let more = share(self.count, 2 * u64::from(j2.saturating_sub(rest)), divisor);
            self.count = self.count.saturating_add(more);
            Phase::Down
        }
    }

    fn count(&self) -> u64 {
        self.count
    }

    /// The planned way down, from any speed: below the top speed it brakes more gently.
    fn stop(&mut self) -> u32 {
        self.corners.j2
    }
}
