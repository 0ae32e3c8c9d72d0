//! Why a call was refused.

use core::fmt;

use crate::order::Refusal;
use crate::profile::Unfit;
use crate::units::{Accel, OutOfRange, Speed};

/// Why a call of [`Steppers`](crate::Steppers) was refused. Axes at rest stay at rest, and moving
/// axes continue unchanged.
///
/// The text says what was wrong, what is allowed and what to do:
///
/// ```
/// use stepwright::{MoveError, Refusal, Speed};
/// let error = MoveError::from(Refusal::TooFast { max: Speed::from_steps(40_000)? });
/// assert_eq!(
///     error.to_string(),
///     "too fast for this board: at most 40000 steps/s for this axis now"
/// );
/// # Ok::<(), stepwright::OutOfRange>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveError {
    /// The planner or the board can't do it.
    Refused(Refusal),
    /// The position of the axis is unknown, so it cannot move to an absolute one.
    PositionUnknown,
    /// The speed is above the limit of the axis.
    AboveLimit {
        /// [`max_speed`](crate::AxisLimits::max_speed) of the axis.
        max: Speed,
    },
    /// The acceleration or the deceleration is above the limit of the axis.
    TooSteep {
        /// The name of the limit in [`AxisLimits`](crate::AxisLimits).
        limit: &'static str,
        /// The limit.
        max: Accel,
    },
    /// The same axis was named twice for one line.
    NamedTwice,
    /// A speed, an acceleration or an axis is out of range.
    Range(OutOfRange),
}

impl From<Refusal> for MoveError {
    fn from(refusal: Refusal) -> MoveError {
        MoveError::Refused(refusal)
    }
}

impl From<Unfit> for MoveError {
    fn from(unfit: Unfit) -> MoveError {
        MoveError::Refused(unfit.into())
    }
}

impl From<OutOfRange> for MoveError {
    fn from(error: OutOfRange) -> MoveError {
        MoveError::Range(error)
    }
}

impl fmt::Display for MoveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MoveError::Refused(refusal) => refusal.fmt(f),
            MoveError::PositionUnknown => f.write_str(
                "the position is not known: set it with set_position, or move by a distance",
            ),
            MoveError::AboveLimit { max } => {
                write!(f, "above the limit of this axis: at most {max} steps/s; raise max_speed")
            }
            MoveError::TooSteep { limit, max } => {
                write!(f, "above the {limit} of this axis: at most {max} steps/s²; raise its limit")
            }
            MoveError::NamedTwice => {
                f.write_str("an axis is named twice: name each axis of a line once")
            }
            MoveError::Range(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for MoveError {}
