//! What the core can't hold, and why.

use std::fmt;

/// A value that was read, but can't be held.
///
/// `name` is the option or the place that it came from, `text` what was typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UnitError {
    /// Millimetres, of a motor whose turn moves its load by nobody knows how much.
    NoMillimetres {
        /// Where it came from.
        name: String,
        /// As typed.
        text: String,
    },
    /// A speed beyond `least` to 1,000,000 steps/s.
    Speed {
        /// Where it came from.
        name: String,
        /// As typed.
        text: String,
        /// 0 or 0.001 steps/s.
        least: &'static str,
        /// Whether it is nothing at all.
        is_zero: bool,
    },
    /// An acceleration beyond 0.001 to 100,000,000 steps/s².
    Accel {
        /// Where it came from.
        name: String,
        /// As typed.
        text: String,
        /// Whether it is below.
        is_small: bool,
    },
    /// A jerk beyond 0.001 to 10¹⁵ steps/s³.
    Jerk {
        /// Where it came from.
        name: String,
        /// As typed.
        text: String,
        /// Whether it is below.
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
