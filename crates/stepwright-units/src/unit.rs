//! The units in which a distance, a speed, an acceleration or a jerk may be typed.

use super::decimal::{Decimal, Rounded};
use stepwright::Geometry;

/// The unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Length {
    Step,
    Turn,
    Degree,
    Radian,
    Millimetre,
}

/// The spellings; messages show the first of each.
const LENGTHS: &[(&str, Length)] = &[
    ("steps", Length::Step),
    ("step", Length::Step),
    ("rev", Length::Turn),
    ("turn", Length::Turn),
    ("turns", Length::Turn),
    ("deg", Length::Degree),
    ("°", Length::Degree),
    ("rad", Length::Radian),
    ("mm", Length::Millimetre),
];

/// Units of quantities other than lengths: times, clocks, currents.
const OTHERS: [&str; 9] = ["s", "ms", "min", "h", "Hz", "kHz", "MHz", "A", "mA"];

/// Whether any typed number may have this unit.
pub fn is_known(text: &str) -> bool {
    split(text).is_some() || OTHERS.contains(&text)
}

/// Whether the motor's steps per turn are needed to convert this unit to steps.
pub fn needs_motor(text: &str) -> bool {
    split(text).is_some_and(|(unit, _)| unit.length != Length::Step)
}

/// A unit: a length per second or per minute; for an acceleration per second again, and for a jerk
/// once more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unit {
    /// The unit of length.
    pub length: Length,
    /// Per minute, not per second.
    pub per_minute: bool,
}

/// The kind of a quantity. Distances have no "per time", speeds one, accelerations two, jerks
/// three.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Distance,
    Speed,
    Accel,
    Jerk,
}

impl Kind {
    /// The suffix: nothing, `/s`, `/s²` or `/s³`.
    pub fn per(self) -> &'static str {
        match self {
            Kind::Distance => "",
            Kind::Speed => "/s",
            Kind::Accel => "/s²",
            Kind::Jerk => "/s³",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Kind::Distance => "a distance",
            Kind::Speed => "a speed",
            Kind::Accel => "an acceleration",
            Kind::Jerk => "a jerk",
        }
    }

    /// Two values.
    pub fn example(self) -> &'static str {
        match self {
            Kind::Distance => "4000 or 10mm",
            Kind::Speed => "1000 or 120rpm",
            Kind::Accel => "4000 or 10rad/s2",
            Kind::Jerk => "400000 or 200rad/s3",
        }
    }

    /// The units to choose from.
    fn choice(self) -> &'static str {
        match self {
            Kind::Distance => "steps, turns, deg, rad or mm",
            Kind::Speed => "steps/s, rpm, rev/s, deg/s, rad/s or mm/s",
            Kind::Accel => "steps/s2, rpm/s, rev/s2, deg/s2, rad/s2 or mm/s2",
            Kind::Jerk => "steps/s3, rpm/s2, rev/s3, deg/s3, rad/s3 or mm/s3",
        }
    }

    fn bare(self) -> &'static str {
        match self {
            Kind::Distance => "steps",
            Kind::Speed => "steps/s",
            Kind::Accel => "steps/s²",
            Kind::Jerk => "steps/s³",
        }
    }
}

impl Unit {
    pub const STEP: Unit = Unit { length: Length::Step, per_minute: false };

    /// Parses the text after the number; without a text the unit is steps.
    pub fn parse(text: &str, kind: Kind) -> Result<Unit, String> {
        if text.is_empty() {
            return Ok(Unit::STEP);
        }
        let wrong = || {
            let (choice, bare) = (kind.choice(), kind.bare());
            format!("'{text}' is no unit of {}: use {choice}; a bare number is {bare}", kind.name())
        };
        match split(text) {
            Some((unit, found)) if found == kind => Ok(unit),
            Some((_, Kind::Speed)) if kind == Kind::Accel => Err(format!(
                "'{text}' is a unit of speed; an acceleration is per second once more: '{}'",
                if text.ends_with("/s") { format!("{text}2") } else { format!("{text}/s") }
            )),
            Some((_, found)) => Err(format!(
                "'{text}' is a unit of {}; for {} use {}",
                found.name().trim_start_matches("an ").trim_start_matches("a "),
                kind.name(),
                kind.choice()
            )),
            None => Err(wrong()),
        }
    }

    /// `number` of this unit as thousandths of a step, rounded once. `None` for millimetres if the
    /// distance per turn is unknown.
    pub fn millisteps(self, number: Decimal, geometry: &Geometry) -> Option<Rounded> {
        self.parts(number, geometry, 1000)
    }

    /// `number` of this unit as whole steps, rounded once. `None` as in
    /// [`millisteps`](Unit::millisteps).
    pub fn whole_steps(self, number: Decimal, geometry: &Geometry) -> Option<Rounded> {
        self.parts(number, geometry, 1)
    }

    /// Converts to parts of a step; a step has `of` of them.
    fn parts(self, number: Decimal, geometry: &Geometry, of: u64) -> Option<Rounded> {
        let turn = of * u64::from(geometry.steps_per_turn());
        let time = if self.per_minute { 60 } else { 1 };
        Some(match self.length {
            Length::Step => number.times(of, time),
            Length::Turn => number.times(turn, time),
            Length::Degree => number.times(turn, 360 * time),
            Length::Radian => number.times_per_tau(turn, time),
            Length::Millimetre => {
                number.times(turn * 1_000_000, u64::from(geometry.nm_per_turn()?) * time)
            }
        })
    }

    /// `number` of this unit in steps, for calculations rather than orders. `None` as in
    /// [`millisteps`](Unit::millisteps).
    pub fn steps(self, number: f64, geometry: &Geometry) -> Option<f64> {
        let turn = f64::from(geometry.steps_per_turn());
        let time = if self.per_minute { 60.0 } else { 1.0 };
        Some(match self.length {
            Length::Step => number / time,
            Length::Turn => number * turn / time,
            Length::Degree => number * turn / (360.0 * time),
            Length::Radian => number * turn / (std::f64::consts::TAU * time),
            Length::Millimetre => number * 1e6 * turn / (f64::from(geometry.nm_per_turn()?) * time),
        })
    }
}

/// Splits `rpm/s` into its unit and its number of "per time".
fn split(text: &str) -> Option<(Unit, Kind)> {
    let text = text.to_lowercase();
    let (length, times) = match text.strip_prefix("rpm") {
        Some(rest) => ("rev", format!("/min{rest}")),
        None => {
            let (length, times) = text.split_at(text.find('/').unwrap_or(text.len()));
            (length, times.to_owned())
        }
    };
    let (_, length) = *LENGTHS.iter().find(|(name, _)| *name == length)?;
    let (per_minute, kind) = match times.as_str() {
        "" => (false, Kind::Distance),
        "/s" => (false, Kind::Speed),
        "/min" => (true, Kind::Speed),
        "/s2" | "/s²" | "/s^2" | "/s/s" => (false, Kind::Accel),
        "/min/s" => (true, Kind::Accel),
        "/s3" | "/s³" | "/s^3" | "/s/s/s" | "/s2/s" | "/s²/s" => (false, Kind::Jerk),
        "/min/s2" | "/min/s²" | "/min/s^2" | "/min/s/s" => (true, Kind::Jerk),
        _ => return None,
    };
    Some((Unit { length, per_minute }, kind))
}
