//! The Nano slave's ramp, counted in steps.
//!
//! The motor jumps to the start speed, accelerates constantly over R steps to
//! the top speed, and brakes over the last R steps:
//!
//! ```text
//!   a = (v_t² − v_s²) / 2R          "braking distance = ramp steps taken so far"
//! ```
//!
//! 2a is stored, rounded to the nearest 10⁻⁶ (steps/s)² per step, and at least that of 0.001
//! steps/s² (a ramp that would be flatter ends sooner). The rest, and its error, is that of the
//! [trapezoid](super::trapezoid). (The document says in one place that the *period* decreases at a
//! constant rate; elsewhere it says constant acceleration, which this law implements.)

use super::path::{Bounds, Path, slope_of};
use super::{Delays, Unfit};
use crate::units::{Accel, Rate, Speed};

/// One of a travel's two ramps: how its change of speed is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ramp {
    /// Over this many steps between start and top speed, 1 … 65535.
    Steps(u16),
    /// At a constant acceleration.
    Accel(Accel),
}

/// A travel with ramps of R steps between start and top speed.
///
/// ```
/// use stepwright::{Rate, Speed, profile::RampSteps};
/// let v = |n| Speed::from_steps(n).unwrap();
/// // S5, T100, R200 of the serial line: 50 to 1000 steps/s over 200 steps.
/// let law = RampSteps::new(Rate::MHZ, v(50), v(1000), 200)?;
/// assert_eq!(law.path(4000)?.braking_steps(), 200);
/// # Ok::<(), stepwright::profile::Unfit>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RampSteps {
    bounds: Bounds,
}

impl RampSteps {
    /// Both ramps over `steps` steps.
    ///
    /// # Errors
    /// [`Unfit::NoRamp`] for 0 steps.
    pub fn new(rate: Rate, start: Speed, top: Speed, steps: u16) -> Result<RampSteps, Unfit> {
        RampSteps::mixed(rate, start, top, Ramp::Steps(steps), Ramp::Steps(steps))
    }

    /// Each ramp given in its own way, by steps or by acceleration.
    ///
    /// # Errors
    /// [`Unfit::NoRamp`] for a ramp of 0 steps.
    pub fn mixed(
        rate: Rate,
        start: Speed,
        top: Speed,
        up: Ramp,
        down: Ramp,
    ) -> Result<RampSteps, Unfit> {
        let slope = |ramp| match ramp {
            Ramp::Steps(0) => Err(Unfit::NoRamp),
            Ramp::Steps(steps) => Ok(slope_over(start, top, steps)),
            Ramp::Accel(a) => Ok(slope_of(a)),
        };
        Ok(RampSteps { bounds: Bounds { rate, start, top, a2: slope(up)?, d2: slope(down)? } })
    }

    /// The motion in closed form, with `pulses` pulses: 0 … 2³¹.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn path(&self, pulses: u32) -> Result<Path, Unfit> {
        Path::new(&self.bounds, pulses)
    }

    /// From the start speed to the top speed, then without an end.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn endless(&self) -> Result<Path, Unfit> {
        self.bounds.check()?;
        Ok(Path::endless(&self.bounds, self.bounds.start.min(self.bounds.top).squared()))
    }

    /// The delay before each of `pulses` pulses; the first is 0.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn delays(&self, pulses: u32) -> Result<Delays, Unfit> {
        Ok(Delays::new(self.path(pulses)?))
    }
}

/// 2a for a ramp of `steps` ≥ 1 steps, at least that of [`Accel::MIN`]: the flattest ramp whose
/// times a 64-bit speed can distinguish.
fn slope_over(start: Speed, top: Speed, steps: u16) -> u64 {
    let steps = u64::from(steps.max(1));
    let rise = top.squared().saturating_sub(start.squared());
    ((rise + steps / 2) / steps).max(slope_of(Accel::MIN))
}
