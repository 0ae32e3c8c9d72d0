//! The speed and the accelerations along a path, and why a path cannot be planned.

/// Why a path cannot be planned or changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unplannable {
    /// The speed is not within [`PACES`].
    Speed,
    /// The acceleration or the deceleration is not within [`PACES`].
    Accel,
    /// The jerk is neither within [`PACES`] nor infinite.
    Jerk,
    /// The length of the path is 0 or infinite.
    Length,
    /// The length of a step of an axis is not a number above 0, or, in a route, not within [`PACES`].
    Step,
    /// An axis makes more than 2³¹ − 1 steps, or a place is NaN.
    TooLong,
    /// The radius is smaller than a step.
    Radius,
    /// The sweep of an arc of a route is 0, NaN, or more than 1,000 turns.
    Sweep,
    /// The jump of an axis is not within [`PACES`].
    Jump,
    /// The junction deviation is not within [`PACES`].
    Deviation,
    /// The tolerance of an [`ArcFit`](crate::ArcFit) is neither 0 nor within [`PACES`].
    Tolerance,
    /// An override is NaN.
    Scale,
    /// A new end, an arc or a limit is not for the axes of the path.
    Axes,
    /// The path is over: there is nothing to change.
    Over,
    /// The path is too fast for an axis.
    TooFast {
        /// The axis, counted from 0.
        axis: usize,
        /// The highest speed along the path that all axes can follow.
        most: f64,
    },
}

impl std::fmt::Display for Unplannable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Unplannable::TooFast { axis, most } => {
                return write!(f, "too fast for axis {axis}: at most {most} along this path");
            }
            Unplannable::Speed => "a speed must be 10^-12 to 10^24",
            Unplannable::Accel => "an acceleration must be 10^-12 to 10^24",
            Unplannable::Jerk => {
                "a jerk must be 10^-12 to 10^24; without one it is a trapezoid"
            }
            Unplannable::Sweep => {
                "the sweep of an arc, in radians, must not be 0, and be 1000 turns at most"
            }
            Unplannable::Jump => "the jump of an axis, its start speed, must be 10^-12 to 10^24",
            Unplannable::Deviation => "the junction deviation must be 10^-12 to 10^24",
            Unplannable::Tolerance => "the tolerance must be 0, or 10^-12 to 10^24",
            Unplannable::Length => "the path leads nowhere: no axis has a step to make",
            Unplannable::Step => "a step must lead somewhere: a distance above 0",
            Unplannable::TooLong => {
                "too long: at most 2147483647 steps of an axis, and of a radius; and a place is a number"
            }
            Unplannable::Radius => "the radius is smaller than a step: nothing would move",
            Unplannable::Scale => "an override is a number: 0.1 to 2 of the ordered speed",
            Unplannable::Axes => {
                "other axes than the path has: a new end takes a position for each, an arc two \
                 different ones"
            }
            Unplannable::Over => "the path is over by then: order a new one",
        })
    }
}

impl std::error::Error for Unplannable {}

/// The range of speeds, accelerations and jerks that can be planned, in any unit.
pub const PACES: std::ops::RangeInclusive<f64> = 1e-12..=1e24;

/// Speed, accelerations and jerk along a path, in the user's unit and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// The speed between the ramps, in unit/s.
    pub speed: f64,
    /// The acceleration, in unit/s².
    pub accel: f64,
    /// The deceleration, in unit/s².
    pub decel: f64,
    /// The jerk, in unit/s³: the rate at which the acceleration changes. If it is infinite, the acceleration
    /// changes at once.
    pub jerk: f64,
}

impl Pace {
    /// A trapezoid: the same acceleration up and down, with infinite jerk.
    pub const fn new(speed: f64, accel: f64) -> Pace {
        Pace { speed, accel, decel: accel, jerk: f64::INFINITY }
    }

    /// The same pace with a different deceleration.
    pub const fn with_decel(self, decel: f64) -> Pace {
        Pace { decel, ..self }
    }

    /// The same pace as an S-curve, with this jerk.
    pub const fn with_jerk(self, jerk: f64) -> Pace {
        Pace { jerk, ..self }
    }

    /// Checks that all values can be planned.
    ///
    /// # Errors
    /// [`Unplannable`] for a value that is not within [`PACES`].
    pub fn check(&self) -> Result<(), Unplannable> {
        let good = |x: f64| PACES.contains(&x);
        let smooth = self.jerk == f64::INFINITY || good(self.jerk);
        match (good(self.speed), good(self.accel) && good(self.decel), smooth) {
            (false, _, _) => Err(Unplannable::Speed),
            (_, false, _) => Err(Unplannable::Accel),
            (_, _, false) => Err(Unplannable::Jerk),
            _ => Ok(()),
        }
    }
}
