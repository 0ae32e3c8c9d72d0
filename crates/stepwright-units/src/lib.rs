//! Distances, speeds, accelerations and jerks as a person types them.
//!
//! ```
//! # use stepwright::Geometry;
//! # use stepwright_units::SpeedArg;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let motor = Geometry::new(200)?;
//! let speed: SpeedArg = "120rpm".parse()?;
//! let held = speed.resolve(&motor, "top speed")?;
//! assert_eq!(held.to_string(), "120rpm → 400 steps/s");
//! assert_eq!(held.value.millisteps(), 400_000);
//! # Ok(())
//! # }
//! ```
//!
//! `10rad/s`, `12.566 rad/s²`, `50mm/s`; a number without a unit counts steps. Conversion has two
//! stages, because the second needs to know the motor:
//!
//! 1. [`DistanceArg`], [`SpeedArg`], [`AccelArg`] and [`JerkArg`] parse the text: a number without
//!    rounding, and a unit. Their errors are texts, for an option of a command.
//! 2. [`SpeedArg::resolve`] converts it to the core's representation with the motor's [`Geometry`],
//!    rounding **once**, and keeps the text, so that a [`Rounded`] can show how it was understood.

#![warn(missing_docs)]
#![forbid(unsafe_code)]

mod decimal;
mod distance;
mod error;
mod machine_unit;
pub mod measure;
mod unit;

use std::fmt::{self, Display};
use std::str::FromStr;

use stepwright::{Accel, Geometry, Jerk, Speed};

use decimal::Decimal;
pub use distance::DistanceArg;
pub use error::UnitError;
pub use machine_unit::{MachineUnit, TURN};
use unit::{Kind, Unit};
pub use unit::{is_known, needs_motor};

/// A distance in millimetres, stored in whole nanometres.
#[derive(Clone, Copy, Debug)]
pub struct MmArg(u32);

impl MmArg {
    /// A distance in millimetres; `None` outside 1 nm to 4.29 m.
    pub fn of(mm: f64) -> Option<MmArg> {
        let nm = (mm * 1e6).round();
        (1.0..=f64::from(u32::MAX)).contains(&nm).then_some(MmArg(nm as u32))
    }

    /// The distance in nanometres, 1 to 2³² − 1.
    pub fn nm(self) -> u32 {
        self.0
    }
}

/// The number of bytes at the beginning of a text that are a number: 5 in `1.5e3mm`.
pub fn number_length(text: &str) -> usize {
    Decimal::length(text)
}

impl FromStr for MmArg {
    type Err = String;

    fn from_str(text: &str) -> Result<MmArg, String> {
        let number = text.strip_suffix("mm").unwrap_or(text).trim();
        let nm = Decimal::parse(number)?.times(1_000_000, 1);
        match u32::try_from(nm.value) {
            Ok(0) | Err(_) => Err("a turn moves the load by 0.000001 to 4294.967295 mm".into()),
            Ok(nm) => Ok(MmArg(nm)),
        }
    }
}

/// A number with its unit, and the text from which it was parsed.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Quantity {
    text: String,
    number: Decimal,
    unit: Unit,
}

impl Quantity {
    fn parse(text: &str, kind: Kind) -> Result<Quantity, String> {
        let text = text.trim();
        let (number, unit) = text.split_at(Decimal::length(text));
        if number.is_empty() {
            return Err(match text.chars().next() {
                Some('-' | '\u{2212}' | '+') => "give it without a sign".into(),
                _ => format!("it begins with a number, like {}", kind.example()),
            });
        }
        let unit = unit.trim();
        if unit.starts_with(',') {
            return Err("write a decimal point, and nothing between thousands".into());
        }
        let (number, unit) = (Decimal::parse(number)?, Unit::parse(unit, kind)?);
        Ok(Quantity { text: text.to_owned(), number, unit })
    }

    /// Whether the number is 0.
    fn is_zero(&self) -> bool {
        self.number.to_f64() == 0.0
    }

    fn no_millimetres(&self, name: &str) -> UnitError {
        UnitError::NoMillimetres { name: name.to_owned(), text: self.text.clone() }
    }

    /// Converts to thousandths of a step; `name` is the option, for the message.
    fn resolve<T>(
        &self,
        geometry: &Geometry,
        name: &str,
        kind: Kind,
        core: impl FnOnce(u64) -> Result<T, UnitError>,
    ) -> Result<Rounded<T>, UnitError> {
        let Some(milli) = self.unit.millisteps(self.number, geometry) else {
            return Err(self.no_millimetres(name));
        };
        let bare = self.unit == Unit::STEP;
        Ok(Rounded {
            value: core(milli.value)?,
            given: self.text.clone(),
            per: kind.per(),
            converted: !bare,
            exact: milli.exact,
        })
    }
}

/// A typed value and its representation in the core.
///
/// Displayed as `400 steps/s`, `120rpm → 400 steps/s`, or, if it was rounded to a thousandth of a
/// step, `10rad/s ≈ 318.31 steps/s`.
#[derive(Clone, Debug)]
pub struct Rounded<T> {
    /// The value in the core.
    pub value: T,
    /// The typed text.
    pub given: String,
    /// Whether nothing was rounded.
    pub exact: bool,
    per: &'static str,
    converted: bool,
}

impl<T> Rounded<T> {
    /// A value that was not typed; `per` is the suffix of its unit after the steps, `/s` for a
    /// speed.
    pub fn of(value: T, per: &'static str) -> Rounded<T>
    where
        T: Display,
    {
        Rounded { given: value.to_string(), value, exact: true, per, converted: false }
    }

    /// Whether it was typed in a unit other than steps.
    pub fn converted(&self) -> bool {
        self.converted
    }
}

impl<T: Display> Display for Rounded<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.converted || !self.exact {
            write!(f, "{} {} ", self.given, if self.exact { '→' } else { '≈' })?;
        }
        let value = self.value.to_string();
        let one = self.per.is_empty() && matches!(value.as_str(), "1" | "-1");
        write!(f, "{value} step{}{}", if one { "" } else { "s" }, self.per)
    }
}

/// A speed without a sign, as typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SpeedArg(Quantity);

impl FromStr for SpeedArg {
    type Err = String;

    fn from_str(text: &str) -> Result<SpeedArg, String> {
        Quantity::parse(text, Kind::Speed).map(SpeedArg)
    }
}

impl SpeedArg {
    /// A speed of this many steps/s.
    pub fn of_steps(number: u32) -> SpeedArg {
        let text = number.to_string();
        SpeedArg(Quantity { text, number: Decimal::whole(number), unit: Unit::STEP })
    }

    /// Converts to steps per second without rounding, for calculations rather than orders; `name`
    /// is the option it came from.
    ///
    /// # Errors
    /// [`UnitError::NoMillimetres`]
    pub fn steps(&self, geometry: &Geometry, name: &str) -> Result<f64, UnitError> {
        let Quantity { number, unit, .. } = &self.0;
        let steps = unit.steps(number.to_f64(), geometry);
        steps.ok_or_else(|| self.0.no_millimetres(name))
    }

    /// The typed text.
    pub fn given(&self) -> &str {
        &self.0.text
    }

    /// Converts to steps per second; `name` is the option it came from.
    ///
    /// # Errors
    /// [`UnitError::NoMillimetres`], [`UnitError::Speed`]
    pub fn resolve(&self, geometry: &Geometry, name: &str) -> Result<Rounded<Speed>, UnitError> {
        self.held(geometry, name, "0")
    }

    /// Converts to steps per second, more than 0; `name` is the option it came from.
    ///
    /// # Errors
    /// [`UnitError::NoMillimetres`], [`UnitError::Speed`]
    pub fn moving(&self, geometry: &Geometry, name: &str) -> Result<Rounded<Speed>, UnitError> {
        self.held(geometry, name, "0.001")
    }

    /// Converts to a speed of at least `least` steps/s, 0 or 0.001.
    fn held(
        &self,
        geometry: &Geometry,
        name: &str,
        least: &'static str,
    ) -> Result<Rounded<Speed>, UnitError> {
        self.0.resolve(geometry, name, Kind::Speed, |milli| {
            let speed = u32::try_from(milli).ok().and_then(|m| Speed::from_millisteps(m).ok());
            let speed = speed.filter(|speed| least == "0" || *speed != Speed::ZERO);
            speed.ok_or_else(|| self.beyond(name, least))
        })
    }

    fn beyond(&self, name: &str, least: &'static str) -> UnitError {
        let (name, text) = (name.to_owned(), self.0.text.clone());
        UnitError::Speed { name, text, least, is_zero: self.0.is_zero() }
    }
}

/// A speed whose sign is a direction: `+1000`, `1000`, `-120rpm`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SignedSpeedArg {
    /// Forward, unless the text began with a minus.
    pub forward: bool,
    /// The magnitude.
    pub speed: SpeedArg,
}

impl FromStr for SignedSpeedArg {
    type Err = String;

    fn from_str(text: &str) -> Result<SignedSpeedArg, String> {
        let text = text.trim();
        let (forward, speed) = match text.strip_prefix(['-', '\u{2212}']) {
            Some(speed) => (false, speed),
            None => (true, text.strip_prefix('+').unwrap_or(text)),
        };
        Ok(SignedSpeedArg { forward, speed: speed.parse()? })
    }
}

/// An acceleration without a sign, as typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AccelArg(Quantity);

impl FromStr for AccelArg {
    type Err = String;

    fn from_str(text: &str) -> Result<AccelArg, String> {
        Quantity::parse(text, Kind::Accel).map(AccelArg)
    }
}

impl AccelArg {
    /// Converts to steps per second squared; `name` is the option it came from.
    ///
    /// # Errors
    /// [`UnitError::NoMillimetres`], [`UnitError::Accel`]
    pub fn resolve(&self, geometry: &Geometry, name: &str) -> Result<Rounded<Accel>, UnitError> {
        self.0.resolve(geometry, name, Kind::Accel, |milli| {
            Accel::from_millisteps(milli).map_err(|_| {
                let (name, text) = (name.to_owned(), self.0.text.clone());
                UnitError::Accel { name, text, is_small: milli == 0 }
            })
        })
    }
}

/// A jerk without a sign, as typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JerkArg(Quantity);

impl FromStr for JerkArg {
    type Err = String;

    fn from_str(text: &str) -> Result<JerkArg, String> {
        Quantity::parse(text, Kind::Jerk).map(JerkArg)
    }
}

impl JerkArg {
    /// Whether it is 0, which means no jerk limit where the jerk is optional.
    pub fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    /// Converts to steps per second cubed; `name` is the option it came from.
    ///
    /// # Errors
    /// [`UnitError::NoMillimetres`], [`UnitError::Jerk`]
    pub fn resolve(&self, geometry: &Geometry, name: &str) -> Result<Rounded<Jerk>, UnitError> {
        self.0.resolve(geometry, name, Kind::Jerk, |milli| {
            Jerk::from_millisteps(milli).map_err(|_| {
                let (name, text) = (name.to_owned(), self.0.text.clone());
                UnitError::Jerk { name, text, is_small: milli == 0 }
            })
        })
    }
}

#[cfg(test)]
mod tests;
