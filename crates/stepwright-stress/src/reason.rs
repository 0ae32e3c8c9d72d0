//! The reasons for a refusal: the words of `last=`.

use std::fmt;
use std::ops::BitOr;

/// A reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // their words on the line are in `WORDS`
pub enum Reason {
    Line,
    Range,
    Axis,
    Busy,
    NoPo,
    NoTravel,
    Killed,
    Uncertain,
    TooFast,
    TooSteep,
    TooSlow,
    Ramp,
    Travel,
    Setting,
    Fault,
    NoAxis,
    NoJerk,
    TooGentle,
    Sum,
    Stopped,
    Limit,
}

/// The words in the order of [`Reason`].
const WORDS: [&str; 21] = [
    "line",
    "range",
    "axis",
    "busy",
    "no-po",
    "no-travel",
    "killed",
    "uncertain",
    "too-fast",
    "too-steep",
    "too-slow",
    "ramp",
    "travel",
    "setting",
    "fault",
    "no-axis",
    "no-jerk",
    "too-gentle",
    "sum",
    "stopped",
    "limit",
];

/// A set of reasons of which a board may name any.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub struct Reasons(u32);

impl Reasons {
    /// No reason: a refusal would be wrong.
    pub const NONE: Reasons = Reasons(0);
    /// Any reason.
    pub const ANY: Reasons = Reasons(u32::MAX);

    /// Whether the set is empty.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether `word` names a reason of the set.
    pub fn has(self, word: &str) -> bool {
        self == Reasons::ANY
            || WORDS.iter().position(|known| *known == word).is_some_and(|at| self.0 >> at & 1 != 0)
    }
}

impl From<Reason> for Reasons {
    fn from(reason: Reason) -> Reasons {
        Reasons(1 << reason as u32)
    }
}

impl BitOr for Reasons {
    type Output = Reasons;
    fn bitor(self, other: Reasons) -> Reasons {
        Reasons(self.0 | other.0)
    }
}

impl BitOr for Reason {
    type Output = Reasons;
    fn bitor(self, other: Reason) -> Reasons {
        Reasons::from(self) | other.into()
    }
}

impl fmt::Debug for Reasons {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Reasons::ANY {
            return f.write_str("any reason");
        }
        let words: Vec<_> = WORDS.into_iter().filter(|word| self.has(word)).collect();
        f.write_str(&words.join(" or "))
    }
}
