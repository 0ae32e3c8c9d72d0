//! What stands in a machine file.
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
//! Each key is a row of [`BOARD`] or [`AXIS`]: the option that it is the default of, and
//! the type that this option reads.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;
use std::str::FromStr;

use serde::Deserialize;
use stepwright_protocol::AxisId;
use toml::{Spanned, Value};

use crate::failure::Failure;
use crate::files;
use crate::order::lease::millis;
use crate::order::motion::RAMP;
use crate::order::target::BAUD;
use crate::quantity::{AccelArg, DistanceArg, JerkArg, MmArg, STEPS_PER_REV, SpeedArg};

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
    key("lease", "lease", About::Board, |text| millis(text).map(drop)),
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

/// A machine file has this many bytes at most.
const MOST: usize = 100_000;

/// The text of a machine file. Nobody waits for a pipe whose other end writes nothing.
pub fn text(path: &Path) -> Result<String, Failure> {
    let about = fs::metadata(path).map_err(|error| Failure::file("read", path, &error))?;
    if !about.is_file() {
        let what = format!("can't read {}: it is no regular file", path.display());
        return Err(Failure::new(what).hint("a machine file is a text file on a disk"));
    }
    files::read(path, MOST)
}

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
    /// Reads the file; `path` is for the message.
    pub fn parse(text: &str, path: &Path) -> Result<Machine, Failure> {
        let at = |place: usize, why: String| {
            let line = text[..place.min(text.len())].matches('\n').count() + 1;
            Failure::new(format!("{}:{line}: {why}", path.display()))
                .hint("`stepwright init --help` says what a machine file has")
                .at(why, line)
        };
        let raw: Raw = toml::from_str(text).map_err(|error| {
            at(error.span().map_or(0, |span| span.start), error.message().to_owned())
        })?;
        // A flattened table has no places: a key of it is found by its name.
        let place = |name: &str| text.find(name).unwrap_or(0);
        let board = raw
            .board
            .iter()
            .map(|(name, value)| value_of(&BOARD, name, value).map_err(|why| at(place(name), why)));
        let board = board.collect::<Result<Values, Failure>>()?;
        let mut axes = Vec::new();
        for (name, table) in &raw.axis {
            let start = name.span().start;
            let axis = name.get_ref().parse().ok().and_then(AxisId::numbered);
            let axis = axis.ok_or_else(|| {
                at(start, format!("axis.{}: axes are numbered 1 to 8", name.get_ref()))
            })?;
            let values = table.iter().map(|(name, value)| {
                value_of(&AXIS, name.get_ref(), value.get_ref())
                    .map_err(|why| at(name.span().start, why))
            });
            let values = values.collect::<Result<Values, Failure>>()?;
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

    /// What all axes of the file have in common.
    pub fn common(&self) -> Values {
        let Some(((_, first), rest)) = self.axes.split_first() else { return Vec::new() };
        let same = |mine: &&(&'static Key, String)| {
            rest.iter().all(|(_, values)| {
                values.iter().any(|(key, text)| key.name == mine.0.name && *text == mine.1)
            })
        };
        first.iter().filter(same).cloned().collect()
    }

    /// What is known of the board.
    pub fn board(&self) -> Values {
        self.board.clone()
    }
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
        Machine::parse(text, Path::new("m.toml")).map_err(|failure| failure.message().to_owned())
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
        assert_eq!(shown(machine.common()), ["steps_per_rev 3200"]);
    }

    #[test]
    fn a_mistake_is_found_on_its_line() {
        for (text, line, part) in [
            ("[axis.1]\nspeed = 3", 2, "there is no speed here"),
            ("prot = '/dev/x'", 1, "there is no prot here; there are port, baud, lease"),
            ("[axis.9]\nmm-per-rev = 8", 1, "numbered 1 to 8"),
            ("[axis.x]\nmm-per-rev = 8", 1, "numbered 1 to 8"),
            ("[axis.1]\n\ntop-speed = '3furlong/s'", 3, "no unit of a speed"),
            ("[axis.1]\ntop-speed = true", 2, "a number"),
            ("[axis.1]\nsteps-per-rev = 0", 2, "1 to 10000000"),
            ("[axis.1]\nramp = 100\naccel = 5", 1, "not by both"),
            ("\nlease = '10ms'", 2, "from 200 ms"),
            ("baud = 10", 1, "50 to 12000000"),
            ("[axis.1\n", 1, ""),
            ("axis = 3", 1, ""),
        ] {
            let why = parse(text).err().unwrap_or_else(|| panic!("{text:?} is taken"));
            assert!(why.starts_with(&format!("m.toml:{line}: ")), "{text:?}: {why}");
            assert!(why.contains(part), "{text:?}: {why}");
        }
    }
}
