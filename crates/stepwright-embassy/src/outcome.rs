//! The outcome of a move.

use core::fmt;

/// The outcome of a move, in the same words as on a PC. One that did not reach its target is no error: look at it.
#[must_use = "an axis that was stopped is no error"]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The axis rests at its target.
    Reached {
        /// The position in steps.
        at: i64,
    },
    /// The axis was stopped and rests elsewhere.
    Stopped {
        /// The position in steps.
        at: i64,
    },
    /// The axis rests at an unknown position: a motor fault or a kill has lost steps.
    Uncertain,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Reached { at } => write!(f, "reached {at}"),
            Outcome::Stopped { at } => write!(f, "stopped at {at}"),
            Outcome::Uncertain => f.write_str("position uncertain"),
        }
    }
}
