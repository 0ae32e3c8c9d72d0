//! The faults that a judge finds.

use std::fmt;
use std::str::FromStr;

/// The rules for a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Every line gets the one answer that the protocol's documentation gives.
    Answer,
    /// `V` answers with the number of steps on the pins.
    Position,
    /// A travel ends after exactly its steps.
    Count,
    /// A travel ends in time.
    Time,
    /// Nothing moves without an order, or beyond it.
    Order,
    /// STEP is high for the width of a pulse, and low for at least as long.
    Pulse,
    /// DIR is set before a step and held after it.
    Direction,
    /// No speed exceeds the top speed.
    Top,
    /// Speeds rise no faster than ordered. From rest they begin with the start speed.
    Rise,
    /// Speeds fall no faster than ordered. To rest they end with the start speed.
    Fall,
    /// A soft stop ends within its time and does not speed up.
    Stop,
    /// A motor that has come to rest rests for one step of its start speed.
    Dwell,
    /// An accepted order has no late step.
    Late,
    /// The drivers are on for long enough before a step.
    Driver,
    /// A closed switch stops its axis.
    Switch,
    /// Nothing moves beyond a soft limit.
    Limit,
    /// An active stop input stops everything.
    Input,
    /// Errors are kept until `!` clears them.
    Errors,
}

/// The names of the rules, in the order of [`Rule`].
const NAMES: [&str; Rule::COUNT] = [
    "answer",
    "position",
    "count",
    "time",
    "order",
    "pulse",
    "direction",
    "top",
    "rise",
    "fall",
    "stop",
    "dwell",
    "late",
    "driver",
    "switch",
    "limit",
    "input",
    "errors",
];

impl Rule {
    /// The number of rules.
    pub const COUNT: usize = 18;

    /// The name of the rule.
    pub fn name(self) -> &'static str {
        NAMES[self as usize]
    }
}

/// The rules that a judge checks.
#[derive(Clone, Copy, Debug)]
pub struct Rules(u32);

impl Default for Rules {
    fn default() -> Rules {
        Rules(u32::MAX)
    }
}

impl Rules {
    /// These rules without the one of this name.
    ///
    /// # Errors
    /// All names, if no rule has this name.
    pub fn without(self, name: &str) -> Result<Rules, String> {
        match NAMES.iter().position(|known| *known == name) {
            Some(at) => Ok(Rules(self.0 & !(1 << at))),
            None => Err(format!("no rule is called {name}; there are {}", NAMES.join(", "))),
        }
    }

    /// Reports a broken rule, if it is one of these rules.
    ///
    /// # Errors
    /// The fault.
    pub fn broken(self, rule: Rule, time: u64, what: impl FnOnce() -> String) -> Result<(), Fault> {
        if self.0 >> rule as u32 & 1 == 0 {
            Ok(())
        } else {
            Err(Fault { rule, time, what: what() })
        }
    }
}

impl FromStr for Rules {
    type Err = String;
    fn from_str(names: &str) -> Result<Rules, String> {
        names.split(',').filter(|name| !name.is_empty()).try_fold(Rules::default(), Rules::without)
    }
}

/// A broken rule, with its time and a description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The rule.
    pub rule: Rule,
    /// The time in ticks since power-up.
    pub time: u64,
    /// A description in a sentence.
    pub what: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} (at tick {})", self.rule.name(), self.what, self.time)
    }
}
