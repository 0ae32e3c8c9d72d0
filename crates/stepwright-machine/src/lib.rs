//! Machine files: how the axes of a machine are built, so that nobody types it twice.
//!
//! ```toml
//! port = "/dev/ttyUSB0"
//! lease = "2s"
//!
//! [axis.1]
//! steps-per-rev = 3200
//! mm-per-rev = 8
//! top-speed = "40mm/s"
//! accel = "200mm/s2"
//! home-speed = "10mm/s"
//! ```
//!
//! Each key is a row of `BOARD` or [`AXIS`]: the option of the command that it is the default of,
//! and the type that this option reads. The command and the Python package read the same files.
//!
//! ```
//! use stepwright_machine::Machine;
//! use stepwright_protocol::AxisId;
//! let machine = Machine::parse("[axis.1]\nmm-per-rev = 8\naccel = '200mm/s2'\n").unwrap();
//! let values = machine.axis(AxisId::FIRST);
//! assert_eq!(values.iter().map(|(key, text)| (key.name, text.as_str())).collect::<Vec<_>>(), [
//!     ("accel", "200mm/s2"),
//!     ("mm-per-rev", "8"),
//! ]);
//! let misread = Machine::parse("[axis.1]\nmm-per-rev = 'far'\n").err().unwrap();
//! assert_eq!(misread.line, 2);
//! ```

#![warn(missing_docs)]
#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::fmt::{self, Display};
use std::ops::RangeInclusive;
use std::str::FromStr;
use std::time::Duration;

use serde::Deserialize;
use serde::de::IgnoredAny;
use stepwright_protocol::{AxisId, LeaseMillis};
use stepwright_units::{AccelArg, DistanceArg, JerkArg, MmArg, SpeedArg, TURN};
use toml::{Spanned, Value};

/// The steps that a turn may have.
pub const STEPS_PER_REV: RangeInclusive<u32> = 1..=10_000_000;

/// The rates of a serial port in bits/s.
pub const BAUD: RangeInclusive<u32> = 50..=12_000_000;

/// The lengths of a ramp in steps, as the line carries them.
pub const RAMP: RangeInclusive<u32> = 1..=999;

/// The shortest lease, in ms: a watched motor is asked for its position every 50 ms, and an answer
/// may take its time.
pub const SHORTEST_LEASE: u128 = 200;

/// Reads a time: a number and its unit, seconds by default.
///
/// # Errors
/// What is wrong with it.
pub fn time(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let end = text.find(|c: char| !matches!(c, '0'..='9' | '.')).unwrap_or(text.len());
    let (number, unit) = text.split_at(end);
    let factor = match unit.trim() {
        "" | "s" => 1.0,
        "ms" => 0.001,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return Err("a time is a number with s, ms, min or h, like 3s".to_owned()),
    };
    let number: f64 = number.parse().map_err(|_| "a time begins with a number, like 3s")?;
    Duration::try_from_secs_f64(number * factor).map_err(|_| "that is too long".to_owned())
}

/// Reads the time of a lease.
///
/// # Errors
/// It is none, or outside 200 ms to 60 s.
pub fn lease(text: &str) -> Result<LeaseMillis, String> {
    let millis = time(text)?.as_millis();
    let lease = u32::try_from(millis).ok().and_then(LeaseMillis::new);
    lease
        .filter(|_| millis >= SHORTEST_LEASE)
        .ok_or_else(|| format!("a lease lasts from {SHORTEST_LEASE} ms to 60 s"))
}

/// What a key is about.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum About {
    /// The board.
    Board,
    /// How the steps of an axis relate to the world.
    Units,
    /// How an axis moves.
    Motion,
    /// How an axis is homed.
    Homing,
}

/// A key of the file.
pub struct Key {
    /// As the file has it.
    pub name: &'static str,
    /// The option of which it is the default, by its id.
    pub id: &'static str,
    /// What it is about.
    pub about: About,
    check: fn(&str) -> Result<(), String>,
}

const fn key(
    name: &'static str,
    id: &'static str,
    about: About,
    check: fn(&str) -> Result<(), String>,
) -> Key {
    Key { name, id, about, check }
}

/// Refuses what the option would not take.
fn reads<T: FromStr<Err: Display>>(text: &str) -> Result<(), String> {
    T::from_str(text).map(drop).map_err(|why| why.to_string())
}

/// Refuses what is not a whole number of this range.
fn whole(text: &str, range: RangeInclusive<u32>) -> Result<(), String> {
    let fits = text.parse().is_ok_and(|number| range.contains(&number));
    let why = || format!("a whole number of {} to {}", range.start(), range.end());
    fits.then_some(()).ok_or_else(why)
}

/// The keys at the top of the file.
const BOARD: [Key; 3] = [
    key("port", "port", About::Board, |_| Ok(())),
    key("baud", "baud", About::Board, |text| whole(text, BAUD)),
    key("lease", "lease", About::Board, |text| lease(text).map(drop)),
];

/// The keys of an axis.
pub const AXIS: [Key; 12] = [
    key("steps-per-rev", "steps_per_rev", About::Units, |text| whole(text, STEPS_PER_REV)),
    key("mm-per-rev", "mm_per_rev", About::Units, reads::<MmArg>),
    key("start-speed", "start_speed", About::Motion, reads::<SpeedArg>),
    key("top-speed", "top_speed", About::Motion, reads::<SpeedArg>),
    key("ramp", "ramp", About::Motion, |text| whole(text, RAMP)),
    key("accel", "accel", About::Motion, reads::<AccelArg>),
    key("decel", "decel", About::Motion, reads::<AccelArg>),
    key("jerk", "jerk", About::Motion, reads::<JerkArg>),
    key("home-speed", "speed", About::Homing, reads::<SpeedArg>),
    key("home-slow", "slow", About::Homing, reads::<SpeedArg>),
    key("home-back-off", "back_off", About::Homing, reads::<DistanceArg>),
    key("home-within", "within", About::Homing, reads::<DistanceArg>),
];

/// What is wrong with a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misread {
    /// The line, from 1.
    pub line: usize,
    /// What.
    pub why: String,
}

impl Display for Misread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.why)
    }
}

impl std::error::Error for Misread {}

/// The values of the board's keys that can be read, whatever else is wrong with the file.
pub fn readable(text: &str) -> Values {
    let table: toml::Table = toml::from_str(text).unwrap_or_default();
    table.iter().filter_map(|(name, value)| value_of(&BOARD, name, value).ok()).collect()
}

/// A file as TOML has it.
#[derive(Deserialize)]
struct Raw {
    #[serde(default)]
    axis: BTreeMap<Spanned<String>, Table>,
    #[serde(flatten)]
    board: toml::Table,
}

type Table = BTreeMap<Spanned<String>, Spanned<Value>>;

/// The values of keys, each as its option takes it.
pub type Values = Vec<(&'static Key, String)>;

/// The whole file.
pub struct Machine {
    board: Values,
    axes: Vec<(AxisId, Values)>,
}

impl Machine {
    /// Reads the file.
    ///
    /// # Errors
    /// What is wrong, and where.
    pub fn parse(text: &str) -> Result<Machine, Misread> {
        let at = |place: usize, why: String| {
            let line = text[..place.min(text.len())].matches('\n').count() + 1;
            Misread { line, why }
        };
        let raw: Raw = toml::from_str(text).map_err(|error| {
            at(error.span().map_or(0, |span| span.start), error.message().to_owned())
        })?;
        // A flattened table has no places: they are read apart.
        let names: BTreeMap<Spanned<String>, IgnoredAny> = toml::from_str(text).unwrap_or_default();
        let place = |name: &str| {
            let found = names.keys().find(|key| key.get_ref() == name);
            found.map_or(0, |key| key.span().start)
        };
        let board = raw
            .board
            .iter()
            .map(|(name, value)| value_of(&BOARD, name, value).map_err(|why| at(place(name), why)));
        let board = board.collect::<Result<Values, Misread>>()?;
        let mut axes = Vec::new();
        for (name, table) in &raw.axis {
            let start = name.span().start;
            let axis = name.get_ref().parse().ok().and_then(AxisId::numbered);
            let axis: AxisId = axis.ok_or_else(|| {
                at(start, format!("axis.{}: axes are numbered 1 to 8", name.get_ref()))
            })?;
            let number = axis.number();
            if *name.get_ref() != number.to_string() {
                return Err(at(start, format!("axis.{}: write it axis.{number}", name.get_ref())));
            }
            let values = table.iter().map(|(name, value)| {
                value_of(&AXIS, name.get_ref(), value.get_ref())
                    .map_err(|why| at(name.span().start, why))
            });
            let values = values.collect::<Result<Values, Misread>>()?;
            let has = |name| values.iter().any(|(key, _)| key.name == name);
            if has("ramp") && has("accel") {
                let why = "a ramp is given by ramp or by accel, not by both".to_owned();
                return Err(at(start, why));
            }
            axes.push((axis, values));
        }
        Ok(Machine { board, axes })
    }

    /// What is known of an axis.
    pub fn axis(&self, axis: AxisId) -> Values {
        let found = self.axes.iter().find(|(known, _)| *known == axis);
        found.map(|(_, values)| values.clone()).unwrap_or_default()
    }

    /// What is known of each axis.
    pub fn axes(&self) -> &[(AxisId, Values)] {
        &self.axes
    }

    /// What all axes of the file have in common. Steps and millimetres of a turn are one thing:
    /// if one of them differs, both do.
    pub fn common(&self) -> Values {
        let Some(((_, first), rest)) = self.axes.split_first() else { return Vec::new() };
        let built_alike = self.built_alike();
        let same = |mine: &&(&'static Key, String)| {
            (built_alike || mine.0.about != About::Units)
                && rest.iter().all(|(_, values)| {
                    values.iter().any(|(key, text)| key.name == mine.0.name && *text == mine.1)
                })
        };
        first.iter().filter(same).cloned().collect()
    }

    /// Whether a turn of all axes of the file has the same steps and millimetres.
    pub fn built_alike(&self) -> bool {
        let mut built = self.axes.iter().map(|(_, values)| built(values));
        let first = built.next();
        built.all(|other| Some(other) == first)
    }

    /// What is known of the board.
    pub fn board(&self) -> Values {
        self.board.clone()
    }
}

/// Steps and nanometres of a turn.
fn built(values: &Values) -> (u32, Option<u32>) {
    let value = |name| values.iter().find(|(key, _)| key.name == name).map(|(_, text)| text);
    let steps = value("steps-per-rev").and_then(|text| text.parse().ok());
    let mm = value("mm-per-rev").and_then(|text| text.parse().ok());
    (steps.unwrap_or(TURN), mm.map(MmArg::nm))
}

/// The value of a key of these, as its option takes it.
fn value_of(
    keys: &'static [Key],
    name: &str,
    value: &Value,
) -> Result<(&'static Key, String), String> {
    let Some(key) = keys.iter().find(|key| key.name == name) else {
        let names: Vec<_> = keys.iter().map(|key| key.name).collect();
        return Err(format!("there is no {name} here; there are {}", names.join(", ")));
    };
    let text = match value {
        Value::String(text) => text.clone(),
        Value::Integer(number) => number.to_string(),
        Value::Float(number) => number.to_string(),
        _ => return Err(format!("{name}: a number, or a number with its unit in quotes")),
    };
    (key.check)(&text).map_err(|why| format!("{name} = '{text}': {why}"))?;
    Ok((key, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Machine, String> {
        Machine::parse(text).map_err(|misread| misread.to_string())
    }

    fn shown(values: Values) -> Vec<String> {
        values.into_iter().map(|(key, text)| format!("{} {text}", key.id)).collect()
    }

    const TWO: &str = "
        port = '/dev/ttyUSB0'
        lease = '2s'
        [axis.1]
        steps-per-rev = 3200
        mm-per-rev = 8
        accel = '200mm/s2'
        [axis.2]
        steps-per-rev = 3200
        mm-per-rev = 1.5
        home-slow = '1mm/s'
    ";

    #[test]
    fn each_axis_has_its_own_values() {
        let machine = parse(TWO).unwrap();
        let axis = |n| shown(machine.axis(AxisId::numbered(n).unwrap()));
        assert_eq!(shown(machine.board()), ["lease 2s", "port /dev/ttyUSB0"]);
        assert_eq!(axis(1), ["accel 200mm/s2", "mm_per_rev 8", "steps_per_rev 3200"]);
        assert_eq!(axis(2), ["slow 1mm/s", "mm_per_rev 1.5", "steps_per_rev 3200"]);
        assert!(axis(3).is_empty());
        assert!(machine.common().is_empty());
    }

    #[test]
    fn steps_and_millimetres_of_a_turn_are_one_thing() {
        let common = |one: &str, two: &str| {
            let machine = parse(&format!("[axis.1]\n{one}\n[axis.2]\n{two}\n")).unwrap();
            (machine.built_alike(), shown(machine.common()))
        };
        let both = "steps-per-rev = 3200\nmm-per-rev = 8\njerk = 5";
        let same = ["jerk 5", "mm_per_rev 8", "steps_per_rev 3200"].map(str::to_owned);
        assert_eq!(common(both, both), (true, same.to_vec()));
        for other in ["steps-per-rev = 1600\nmm-per-rev = 8", "steps-per-rev = 3200", ""] {
            let (alike, common) = common(both, &format!("{other}\njerk = 5"));
            assert_eq!((alike, common), (false, vec!["jerk 5".to_owned()]), "{other}");
        }
        // 200 is what a turn has that nobody counts.
        assert!(common("steps-per-rev = 200", "jerk = 5").0);
    }

    #[test]
    fn a_mistake_is_found_on_its_line() {
        for (text, line, part) in [
            ("[axis.1]\nspeed = 3", 2, "there is no speed here"),
            ("prot = '/dev/x'", 1, "there is no prot here; there are port, baud, lease"),
            ("[axis.9]\nmm-per-rev = 8", 1, "numbered 1 to 8"),
            ("[axis.x]\nmm-per-rev = 8", 1, "numbered 1 to 8"),
            ("[axis.01]\nmm-per-rev = 8", 1, "axis.01: write it axis.1"),
            ("[axis.1]\nmm-per-rev = 8\n[axis.'+1']", 3, "axis.+1: write it axis.1"),
            ("[axis.1]\nmm-per-rev = 8\n[axis.1]", 3, "duplicate key"),
            ("[axis.1]\n\ntop-speed = '3furlong/s'", 3, "no unit of a speed"),
            ("[axis.1]\ntop-speed = true", 2, "a number"),
            ("[axis.1]\nsteps-per-rev = 0", 2, "1 to 10000000"),
            ("[axis.1]\nramp = 100\naccel = 5", 1, "not by both"),
            ("\nlease = '10ms'", 2, "from 200 ms"),
            ("baud = 10", 1, "50 to 12000000"),
            ("[axis.1\n", 1, ""),
            ("axis = 3", 1, ""),
            // A name that stands somewhere else before.
            ("# no lease here\nport = '/dev/x'\nlease = true", 3, "a number"),
            ("port = '/dev/x'\nt = 3", 2, "there is no t here"),
            ("port = '/dev/x'\n\"lea\\u0073e\" = true", 2, "a number"),
        ] {
            let why = parse(text).err().unwrap_or_else(|| panic!("{text:?} is taken"));
            assert!(why.starts_with(&format!("line {line}: ")), "{text:?}: {why}");
            assert!(why.contains(part), "{text:?}: {why}");
        }
    }
}
