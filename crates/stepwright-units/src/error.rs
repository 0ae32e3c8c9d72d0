//! Values that the core can't represent.

use std::fmt;

/// A value that was parsed but that the core can't represent.
///
/// `name` is the option or the place it came from, `text` the typed text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnitError {
    /// Millimetres, for a motor whose distance per turn is unknown.
    NoMillimetres {
        /// Where it came from.
        name: String,
        /// As typed.
        text: String,
    },
    /// A speed outside `least` to 1,000,000 steps/s.
    Speed {
        /// Where it came from.
        name: String,
        /// As typed.
        text: String,
        /// 0 or 0.001 steps/s.
        least: &'static str,
        /// Whether the speed is 0.
        is_zero: bool,
    },
    /// An acceleration outside 0.001 to 100,000,000 steps/s².
    Accel {
        /// Where it came from.
        name: String,
        /// As typed.
        text: String,
        /// Whether it is below the range.
        is_small: bool,
    },
    /// A jerk outside 0.001 to 10¹⁵ steps/s³.
    Jerk {
        /// Where it came from.
        name: String,
        /// As typed.
        text: String,
        /// Whether it is below the range.
        is_small: bool,
    },
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UnitError::NoMillimetres { name, text } => {
                write!(f, "{name} {text}: millimetres need the distance of one turn")
            }
            UnitError::Speed { name, text, least, .. } => {
                write!(f, "{name} must be {least} to 1,000,000 steps/s, not {text}")
            }
            UnitError::Accel { name, text, is_small: true } => {
                write!(f, "{name} {text} is less than 0.001 steps/s²")
            }
            UnitError::Accel { name, text, .. } => {
                write!(f, "{name} {text} is more than 100000000 steps/s²")
            }
            UnitError::Jerk { name, text, is_small: true } => {
                write!(f, "{name} {text} is less than 0.001 steps/s³")
            }
            UnitError::Jerk { name, text, .. } => {
                write!(f, "{name} {text} is more than 1000000000000000 steps/s³")
            }
        }
    }
}

impl std::error::Error for UnitError {}
