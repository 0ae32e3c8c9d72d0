//! Machine files: the data of a machine's axes, so that nobody types them twice.
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
//! Each key is a row of `BOARD` or [`AXIS`]: the option of the command whose default it is, and the type
//! that the option reads. The command and the Python package read the same files.
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

/// The range of steps per turn.
pub const STEPS_PER_REV: RangeInclusive<u32> = 1..=10_000_000;

/// The rates of a serial port in bits/s.
pub const BAUD: RangeInclusive<u32> = 50..=12_000_000;

/// The range of a ramp's length in steps, as the line carries it.
pub const RAMP: RangeInclusive<u32> = 1..=999;

/// The shortest lease in ms. The host asks a watched motor for its position every 50 ms, and an answer
/// takes time too.
pub const SHORTEST_LEASE: u128 = 200;

/// Reads a time: a number and its unit, seconds by default.
///
/// # Errors
/// What is wrong with the text.
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
/// The text is no time, or the time is outside 200 ms to 60 s.
pub fn lease(text: &str) -> Result<LeaseMillis, String> {
    let millis = time(text)?.as_millis();
    let lease = u32::try_from(millis).ok().and_then(LeaseMillis::new);
    lease
        .filter(|_| millis >= SHORTEST_LEASE)
        .ok_or_else(|| format!("a lease lasts from {SHORTEST_LEASE} ms to 60 s"))
}

/// The subject of a key.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum About {
    /// The board.
    Board,
    /// The relation of an axis' steps to turns and millimetres.
    Units,
    /// The motion of an axis.
    Motion,
    /// The homing of an axis.
    Homing,
}

/// A key of the file.
pub struct Key {
    /// The name in the file.
    pub name: &'static str,
    /// The id of the option whose default it is.
    pub id: &'static str,
    /// Its subject.
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

/// Refuses a text that the option would refuse.
fn reads<T: FromStr<Err: Display>>(text: &str) -> Result<(), String> {
    T::from_str(text).map(drop).map_err(|why| why.to_string())
}

/// Refuses a text that is not a whole number in this range.
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

/// An error in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misread {
    /// The line, counted from 1.
    pub line: usize,
    /// What is wrong.
    pub why: String,
}

impl Display for Misread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.why)
    }
}

impl std::error::Error for Misread {}

/// The values of the board's keys that can be read, even if the rest of the file is wrong.
pub fn readable(text: &str) -> Values {
    let table: toml::Table = toml::from_str(text).unwrap_or_default();
    table.iter().filter_map(|(name, value)| value_of(&BOARD, name, value).ok()).collect()
}

/// The content of a file as TOML.
#[derive(Deserialize)]
struct Raw {
    #[serde(default)]
    axis: BTreeMap<Spanned<String>, Table>,
    #[serde(flatten)]
    board: toml::Table,
}

type Table = BTreeMap<Spanned<String>, Spanned<Value>>;

/// Keys with their values as their options take them.
pub type Values = Vec<(&'static Key, String)>;

/// A whole machine file.
pub struct Machine {
    board: Values,
    axes: Vec<(AxisId, Values)>,
}

impl Machine {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// What is wrong, and in which line.
    pub fn parse(text: &str) -> Result<Machine, Misread> {
        let at = |place: usize, why: String| {
            let line = text[..place.min(text.len())].matches('\n').count() + 1;
            Misread { line, why }
        };
        let raw: Raw = toml::from_str(text).map_err(|error| {
            at(error.span().map_or(0, |span| span.start), error.message().to_owned())
        })?;
        // A flattened table has no places. A second parse finds them.
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

    /// The values of an axis.
    pub fn axis(&self, axis: AxisId) -> Values {
        let found = self.axes.iter().find(|(known, _)| *known == axis);
        found.map(|(_, values)| values.clone()).unwrap_or_default()
    }

    /// The values of each axis.
    pub fn axes(&self) -> &[(AxisId, Values)] {
        &self.axes
    }

    /// The values that all axes of the file share. Steps and millimetres per turn belong together: if one
    /// of them differs, neither is shared.
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

    /// Whether all axes of the file have the same steps and millimetres per turn.
    pub fn built_alike(&self) -> bool {
        let mut built = self.axes.iter().map(|(_, values)| built(values));
        let first = built.next();
        built.all(|other| Some(other) == first)
    }

    /// The values of the board.
    pub fn board(&self) -> Values {
        self.board.clone()
    }
}

/// Steps and nanometres per turn.
fn built(values: &Values) -> (u32, Option<u32>) {
    let value = |name| values.iter().find(|(key, _)| key.name == name).map(|(_, text)| text);
    let steps = value("steps-per-rev").and_then(|text| text.parse().ok());
    let mm = value("mm-per-rev").and_then(|text| text.parse().ok());
    (steps.unwrap_or(TURN), mm.map(MmArg::nm))
}

/// The key with this name and its value as the option takes it.
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
        // A turn has 200 steps unless the file says otherwise.
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
            // The same name occurs earlier in another place.
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
