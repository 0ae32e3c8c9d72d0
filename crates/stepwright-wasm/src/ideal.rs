//! The ideal course of a travel, in steps and seconds: formulas in `f64` that share nothing with the core's
//! integers.

use stepwright::{Accel, Jerk, Speed};
use stepwright_oracle::{IdealSCurve, IdealTrapezoid, JerkLimits};

/// Steps/s.
pub(crate) fn steps_per_second(speed: Speed) -> f64 {
    f64::from(speed.millisteps()) / 1e3
}

/// Steps/s².
fn steps_per_second2(accel: Accel) -> f64 {
    accel.millisteps() as f64 / 1e3
}

/// Constant acceleration, top speed, constant deceleration, for `pulses` pulses.
pub(crate) fn constant(
    start: Speed,
    top: Speed,
    (up, down): (Accel, Accel),
    pulses: u32,
) -> IdealTrapezoid<f64> {
    let start = steps_per_second(start);
    let slopes = (2.0 * steps_per_second2(up), 2.0 * steps_per_second2(down));
    let length = f64::from(pulses.saturating_sub(1));
    IdealTrapezoid::new((start, start), steps_per_second(top), slopes, length)
}

/// Limited jerk, for `pulses` pulses from the start speed and back to it.
pub(crate) fn s_curve(
    start: Speed,
    top: Speed,
    (up, down): (Accel, Accel),
    jerk: Jerk,
    pulses: u32,
) -> IdealSCurve<f64> {
    let limits = JerkLimits {
        start: steps_per_second(start),
        top: steps_per_second(top),
        accel: steps_per_second2(up),
        decel: steps_per_second2(down),
        jerk: jerk.millisteps() as f64 / 1e3,
    };
    IdealSCurve::new(limits, f64::from(pulses.saturating_sub(1)))
}
