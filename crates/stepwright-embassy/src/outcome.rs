//! What became of a move.

use core::fmt;

/// What became of a move: the same words as on a PC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The axis rests where it was ordered to.
    Reached {
        /// There, in steps.
        at: i64,
    },
    /// It rests elsewhere: it was stopped.
    Stopped {
        /// There, in steps.
        at: i64,
    },
    /// It rests, and it is not known where: a fault of its motor or a kill has lost steps.
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
