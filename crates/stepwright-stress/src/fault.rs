//! What a judge finds wrong.

use std::fmt;
use std::str::FromStr;

/// The rules that a board is held to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Every line has the one answer that the protocol's documentation gives it.
    Answer,
    /// `V` tells the steps on the pins.
    Position,
    /// A travel ends after exactly its steps.
    Count,
    /// It ends in time.
    Time,
    /// Nothing moves but by order, and nothing beyond it.
    Order,
    /// STEP is high for the pulse's width, and low for as long.
    Pulse,
    /// DIR is set before a step and kept after it.
    Direction,
    /// Speeds keep to the top speed.
    Top,
    /// Speeds rise no faster than ordered, from rest with the start speed.
    Rise,
    /// Speeds fall no faster than ordered, to rest from the start speed.
    Fall,
    /// A soft stop ends within its time, and speeds up no more.
    Stop,
    /// A motor that has come to rest stays there for one step of its start speed.
    Dwell,
    /// An order that was accepted has no late step.
    Late,
    /// Drivers are on, and for long enough, before a step.
    Driver,
    /// A closed switch stops its axis.
    Switch,
    /// Nothing goes beyond a soft limit.
    Limit,
    /// An input that stops everything does.
    Input,
    /// Errors are kept until they are cleared.
    Errors,
}

/// Their names, in the order of [`Rule`].
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
    /// How many there are.
    pub const COUNT: usize = 18;

    /// Its name.
    pub fn name(self) -> &'static str {
        NAMES[self as usize]
    }
}

/// The rules that a judge keeps an eye on.
#[derive(Clone, Copy, Debug)]
pub struct Rules(u32);

impl Default for Rules {
    fn default() -> Rules {
        Rules(u32::MAX)
    }
}

impl Rules {
    /// Without one of them.
    ///
    /// # Errors
    /// If no rule has this name: all names.
    pub fn without(self, name: &str) -> Result<Rules, String> {
        match NAMES.iter().position(|known| *known == name) {
            Some(at) => Ok(Rules(self.0 & !(1 << at))),
            None => Err(format!("no rule is called {name}; there are {}", NAMES.join(", "))),
        }
    }

    /// A fault, if its rule is looked at.
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

/// A rule that was broken, when and how.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Which.
    pub rule: Rule,
    /// In ticks since the board was switched on.
    pub time: u64,
    /// In a sentence.
    pub what: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {} (at tick {})", self.rule.name(), self.what, self.time)
    }
}
