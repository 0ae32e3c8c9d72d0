//! How fast along a path, and why one can't be planned.

/// Why a path can't be planned, or changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unplannable {
    /// The speed is beyond [`PACES`], or no number.
    Speed,
    /// The acceleration, or the deceleration, is.
    Accel,
    /// The jerk is, and not infinite either.
    Jerk,
    /// The path has no length, or an endless one.
    Length,
    /// A step of an axis leads nowhere.
    Step,
    /// An axis makes more than 2³¹ − 1 steps, or a place is no number.
    TooLong,
    /// The radius is smaller than a step.
    Radius,
    /// The sweep of an arc of a route is 0, no number, or more than 1,000 turns.
    Sweep,
    /// The jump of an axis is beyond [`PACES`].
    Jump,
    /// The junction deviation is.
    Deviation,
    /// The tolerance of a [`ArcFit`](crate::ArcFit) is, and not 0 either.
    Tolerance,
    /// An override that is no number.
    Scale,
    /// A new end, or an arc, for other axes than the path has.
    Axes,
    /// The path is over: there is nothing to change.
    Over,
    /// An axis can't follow.
    TooFast {
        /// Which one, counted from 0.
        axis: usize,
        /// The highest speed along the path that it, and every other, can follow.
        most: f64,
    },
}

impl std::fmt::Display for Unplannable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Unplannable::TooFast { axis, most } => {
                return write!(f, "too fast for axis {axis}: at most {most} along this path");
            }
            Unplannable::Speed => "the speed along the path must be 10^-12 to 10^24",
            Unplannable::Accel => "the acceleration along the path must be 10^-12 to 10^24",
            Unplannable::Jerk => {
                "the jerk along the path must be 10^-12 to 10^24; without one it is a \
                 trapezoid"
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
                "too long: at most 2147483647 steps of an axis, and of a radius"
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

/// Speeds, accelerations and jerks that can be planned with, in any unit.
pub const PACES: std::ops::RangeInclusive<f64> = 1e-12..=1e24;

/// Speed, accelerations and jerk along a path, in the user's unit and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Unit/s between the ramps.
    pub speed: f64,
    /// Unit/s², up.
    pub accel: f64,
    /// Unit/s², down.
    pub decel: f64,
    /// Unit/s³, by which the acceleration comes and goes; infinite: at once.
    pub jerk: f64,
}

impl Pace {
    /// A trapezoid: the same acceleration up and down, which comes and goes at once.
    pub const fn new(speed: f64, accel: f64) -> Pace {
        Pace { speed, accel, decel: accel, jerk: f64::INFINITY }
    }

    /// The same with a deceleration of its own.
    pub const fn with_decel(self, decel: f64) -> Pace {
        Pace { decel, ..self }
    }

    /// The same as an S-curve.
    pub const fn with_jerk(self, jerk: f64) -> Pace {
        Pace { jerk, ..self }
    }

    /// Whether all of it makes sense.
    ///
    /// # Errors
    /// [`Unplannable`]: what is beyond [`PACES`].
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
