//! Constant acceleration to a top speed, and constant deceleration.
//!
//! ```text
//!   v(s)² = v_s² + 2·a·s            rise    (s steps after the first pulse)
//!   v(s)² = v_s² + 2·d·(L − s)      fall    (L = m − 1 steps in all)
//! ```
//!
//! Both are capped at the top speed; if that is out of reach, rise and fall meet (Austin, Eq 19).
//! The m pulses are at s = 0 … L of this continuous profile, the first at time 0. The error of
//! every pulse is below one tick, or 2⁻⁴⁰ of the elapsed time if that is larger (0.82 ticks by
//! construction; see `docs/accuracy.md` for measurements).

use super::path::{Bounds, Path, slope_of};
use super::{Delays, Unfit};
use crate::units::{Accel, Rate, Speed};

/// A travel with constant acceleration, top speed and constant deceleration.
///
/// ```
/// use stepwright::{Accel, Rate, Speed, profile::Trapezoid};
/// let law = Trapezoid::new(
///     Rate::MHZ,
///     Speed::ZERO,
///     Speed::from_steps(400)?,
///     Accel::from_steps(400)?,
/// );
/// let delays: Vec<u32> = law.delays(200)?.collect();
/// assert_eq!(delays.len(), 200);
/// // The first step from rest takes √(2/a) (Austin, Eq 7).
/// assert_eq!(delays[1], 70_711);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trapezoid {
    bounds: Bounds,
}

impl Trapezoid {
    /// From `start` (may be 0) at `accel` to `top`, and back at the same rate. If the top speed is
    /// not above the start speed, the whole travel is at the top speed.
    pub const fn new(rate: Rate, start: Speed, top: Speed, accel: Accel) -> Trapezoid {
        let slope = slope_of(accel);
        Trapezoid { bounds: Bounds { rate, start, top, a2: slope, d2: slope } }
    }

    /// This travel with another deceleration.
    pub const fn with_decel(mut self, decel: Accel) -> Trapezoid {
        self.bounds.d2 = slope_of(decel);
        self
    }

    /// The motion in closed form, with `pulses` pulses: 0 … 2³¹.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn path(&self, pulses: u32) -> Result<Path, Unfit> {
        Path::new(&self.bounds, pulses)
    }

    /// The delay before each of `pulses` pulses; the first is 0.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn delays(&self, pulses: u32) -> Result<Delays, Unfit> {
        Ok(Delays::new(self.path(pulses)?))
    }
}
