//! A ramp that changes its acceleration anywhere (Austin, Eq 13, 17, 18).
//!
//! ```text
//!   c(i) = c(i−1) − 2·c(i−1) / (4·n(i) + 1)       n(i) = n(i−1) + 1
//!   (n₁ + ½)·a₁ = (n₂ + ½)·a₂                     where a₁ changes to a₂
//! ```
//!
//! n has a sign, like a: negative n are deceleration, and count towards 0. (Eq 17 is the same
//! without the half step, and less exact without it.) Only a = 0 is a special case: the delay is
//! kept, and n · a remembered.
//!
//! n is stored in 2⁻²⁸ steps. Error against the formulas in f64: each delay below one tick.

use super::count::{C0, Order};
use super::piecewise::divisor;
use crate::share::share;
use stepwright::fixed::Q32;
use stepwright::profile::Unfit;
use stepwright::units::{Accel, Rate, Speed, Ticks};

/// One step and half a step, in the units of n.
const STEP: u64 = 1 << 28;
const HALF: u64 = STEP / 2;
/// n stays below 2³³ steps.
const LARGEST: u64 = STEP << 33;

/// The change of speed from here on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slope {
    /// Accelerate.
    Up(Accel),
    /// Keep the speed.
    Level,
    /// Decelerate, down to rest.
    Down(Accel),
}

/// A motion without an end, whose acceleration is changed on the way.
///
/// As an iterator it returns the delay before each pulse, the first 0. While braking it ends with
/// the pulse at which the motor is at rest.
///
/// ```
/// use stepwright_austin::{C0, Ramp, Slope};
/// use stepwright::{Accel, Rate};
/// let a = |n| Accel::from_steps(n).unwrap();
/// let mut ramp = Ramp::new(Rate::MHZ, a(400), C0::Reduced)?;
/// let up: Vec<u32> = ramp.by_ref().take(101).collect();
/// ramp.set(Slope::Level);
/// assert_eq!(ramp.next(), Some(3_545)); // c99, as before
/// ramp.set(Slope::Down(a(800)));
/// assert_eq!(ramp.by_ref().count(), 49); // half of the way up
/// assert_eq!(up[1], 47_800);
/// # Ok::<(), stepwright::profile::Unfit>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ramp {
    /// c₀, until it has been handed out.
    lead: Option<Q32>,
    first: bool,
    count: Q32,
    /// |n + ½| in 2⁻²⁸ steps, for the acceleration of `slope`; while level, for that of the slope before.
    far: u64,
    accel: Accel,
    slope: Slope,
    part: u32,
}

impl Ramp {
    /// A ramp from rest at `accel`.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn new(rate: Rate, accel: Accel, c0: C0) -> Result<Ramp, Unfit> {
        // The top speed does not matter, so it is as high as possible.
        let order = Order::new(rate, Speed::MAX, accel).fitted(1 << 31)?;
        let (lead, count) = c0.counts(order.exact(accel));
        Ok(Ramp {
            lead: Some(lead),
            first: true,
            count,
            far: HALF,
            accel,
            slope: Slope::Up(accel),
            part: 1 << 31,
        })
    }

    /// Changes the acceleration: Eq 18.
    pub fn set(&mut self, slope: Slope) {
        if let Slope::Up(accel) | Slope::Down(accel) = slope {
            let (from, to) = (self.accel.millisteps(), accel.millisteps());
            self.far = share(self.far, from, to).min(LARGEST);
            self.accel = accel;
        }
        self.slope = slope;
    }

    /// n of Eq 13 in 2⁻²⁸ steps: negative on the way down, `None` while level.
    pub fn n(&self) -> Option<i64> {
        let far = self.far as i64; // below 2⁶¹
        match self.slope {
            Slope::Up(_) => Some(far - HALF as i64),
            Slope::Level => None,
            Slope::Down(_) => Some(-far - HALF as i64),
        }
    }

    /// Makes one step; `false` at rest.
    fn step(&mut self) -> bool {
        match self.slope {
            Slope::Level => {}
            Slope::Up(_) => {
                self.far = (self.far + STEP).min(LARGEST);
                let (n, d) = divisor(4 * self.far - STEP); // 4n + 1
                self.count -= share(self.count, n, d);
            }
            Slope::Down(_) => {
                // n = −1 is the hold after the last pulse.
                if self.far < STEP + HALF {
                    return false;
                }
                self.far -= STEP;
                let (n, d) = divisor(4 * self.far + STEP); // −(4n + 1)
                self.count = self.count.saturating_add(share(self.count, n, d));
            }
        }
        true
    }
}

impl Iterator for Ramp {
    type Item = Ticks;

    fn next(&mut self) -> Option<Ticks> {
        if core::mem::take(&mut self.first) {
            return Some(0);
        }
        let count = match self.lead.take() {
            Some(lead) => lead,
            None if self.step() => self.count,
            None => return None,
        };
        let due = count.saturating_add(self.part.into());
        self.part = due as u32;
        Some((due >> 32) as Ticks)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn ticks(ramp: &Ramp) -> f64 {
        ramp.count as f64 / 2f64.powi(32)
    }

    /// Table 2, whose 2,803.498 is a misprint of 2,802.498.
    #[test]
    fn table_2() {
        let a = Accel::from_steps; // c198 is given: only their ratios matter
        let exact = 2813.067; // c198 by Eq 8
        let ramp = Ramp::new(Rate::MHZ, a(10).unwrap(), C0::Reduced).unwrap();
        let count = (exact * 2f64.powi(32)) as Q32;
        let mut ramp = Ramp { lead: None, first: false, count, far: 198 * STEP + HALF, ..ramp };
        let close = |got: f64, want: f64| assert!((got - want).abs() < 6e-4, "{got} {want}");
        let n = |ramp: &Ramp| ramp.n().unwrap() as f64 / STEP as f64;
        ramp.step();
        close(ticks(&ramp), 2806.008);
        let mut slower = ramp.clone();
        slower.set(Slope::Up(a(5).unwrap()));
        close(n(&slower), 398.5);
        for (next, count) in [(399.5, 2802.498), (400.5, 2799.001)] {
            slower.step();
            close(n(&slower), next);
            close(ticks(&slower), count);
        }
        ramp.set(Slope::Down(a(20).unwrap()));
        close(n(&ramp), -100.25);
        for (next, count) in [(-99.25, 2820.180), (-98.25, 2834.568)] {
            ramp.step();
            close(n(&ramp), next);
            close(ticks(&ramp), count);
        }
    }

    #[test]
    fn down_takes_back_what_up_did() {
        let accel = Accel::from_steps(400).unwrap();
        let mut ramp = Ramp::new(Rate::MHZ, accel, C0::Reduced).unwrap();
        let up: Vec<_> = ramp.by_ref().take(200).collect();
        ramp.set(Slope::Down(accel));
        let down: Vec<_> = ramp.collect();
        assert_eq!(down.len(), 198);
        for (a, b) in up[2..].iter().rev().skip(1).zip(&down) {
            assert!(a.abs_diff(*b) <= 1, "{a} {b}");
        }
    }

    /// Any change at any time: no panic, and the speed follows v² = v₀² ± 2as.
    #[test]
    fn level_and_back_changes_nothing() {
        let a = |n| Accel::from_steps(n).unwrap();
        let mut plain = Ramp::new(Rate::MHZ, a(1_000), C0::Reduced).unwrap();
        let mut other = plain.clone();
        for _ in 0..50 {
            plain.next();
            other.next();
        }
        other.set(Slope::Level);
        let held = other.next().unwrap();
        assert!(held.abs_diff(other.next().unwrap()) <= 1);
        other.set(Slope::Up(a(1_000)));
        for _ in 0..50 {
            assert!(plain.next().unwrap().abs_diff(other.next().unwrap()) <= 1);
        }
    }

    #[test]
    fn extremes_hold() {
        for (first, then) in [(1, 100_000_000_000), (100_000_000_000, 1)] {
            let a = |n| Accel::from_millisteps(n).unwrap();
            let Ok(mut ramp) = Ramp::new(Rate::MHZ, a(first), C0::Exact) else {
                assert_eq!(first, 1);
                continue;
            };
            for slope in [Slope::Up(a(then)), Slope::Down(a(first)), Slope::Down(a(then))] {
                ramp.set(slope);
                assert!(ramp.by_ref().take(1_000).count() <= 1_000);
            }
        }
    }
}
