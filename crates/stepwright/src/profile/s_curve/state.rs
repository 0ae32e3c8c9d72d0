//! The state of a motor at a moment, and a new motion from that state.

use super::course::{Limits, Motion};
use super::{Curve, SCurve, thousandths};
use crate::profile::Unfit;
use crate::units::Speed;
use crate::wide::Wide;

/// Speed and acceleration at a moment: the beginning of a changed motion.
///
/// ```
/// use stepwright::{Accel, Jerk, Rate, Speed, profile::SCurve};
/// let law = SCurve::new(
///     Rate::MHZ,
///     Speed::ZERO,
///     Speed::from_steps(1000)?,
///     Accel::from_steps(4000)?,
///     Jerk::from_steps(48_000)?,
/// );
/// let there = law.curve(2001)?;
/// // At pulse 900, back to where it began: through a rest, and further than that.
/// let back = law.from_state(there.state_at(900), -900)?;
/// assert_eq!(back.place_of(back.pulses()), -900);
/// assert_eq!(back.pulses(), 1 + 165 + 165 + 900);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State(pub(super) Motion);

impl State {
    /// Standstill.
    pub const REST: State = State(Motion::steady(Wide::ZERO));

    /// At a constant speed.
    pub fn moving(speed: Speed, forward: bool) -> State {
        State(Motion::steady(thousandths(speed.millisteps().into()).flipped(!forward)))
    }

    /// The speed in 0.001 steps/s, rounded to nearest; negative if backward.
    pub fn speed(&self) -> i64 {
        nearest(self.0.v)
    }

    /// The acceleration in 0.001 steps/s², rounded to nearest; negative if backward.
    pub fn accel(&self) -> i64 {
        nearest(self.0.a)
    }
}

fn nearest(x: Wide) -> i64 {
    (x * Wide::whole(1000) + Wide::whole(1).scaled(-1)).floor()
}

impl SCurve {
    /// A new motion from `state`: the fastest within this law's limits that ends at rest `distance`
    /// steps away, forward or (negative) backward, at most 2³¹ − 1.
    ///
    /// It continues from the present speed and acceleration. Values beyond the limits are brought
    /// back as fast as the limits allow. A target at which the motor can still stop is never
    /// passed; otherwise the motor returns to it. The law's start speed is not used. The first
    /// pulse is the one that has just been made.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it, or if coming to rest takes more than 2³¹ steps.
    pub fn from_state(&self, state: State, distance: i32) -> Result<Curve, Unfit> {
        if self.top == Speed::ZERO {
            return Err(Unfit::Standstill);
        }
        Curve::new(self.rate, &self.limits(Wide::ZERO), state.0, distance.into())
    }

    /// A soft stop: to rest on the next whole step at which the limits allow it.
    ///
    /// If the stop would end between two steps, the rest of a step is travelled before the speed
    /// falls, no faster than the present speed or than a step from rest allows.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it, or if coming to rest takes more than 2³¹ steps.
    pub fn stop(&self, state: State) -> Result<Curve, Unfit> {
        let limits = self.limits(Wide::ZERO);
        let v = limits.at_no_acceleration(state.0);
        let crawl = limits.jerk.above_cube_root().min(limits.up.min(limits.down).sqrt());
        let limits = Limits { top: v.abs().max(crawl), ..limits };
        let way = limits.stopping(state.0);
        let way = if v.is_minus() { way.floor() } else { way.ceil() };
        Curve::new(self.rate, &limits, state.0, way)
    }
}
