//! Distances, speeds, accelerations and jerks as a person types them.
//!
//! `120rpm`, `10rad/s`, `12.566 rad/s²`, `50mm/s`; a bare number counts steps.
//! Two moments, because the second needs other options of the command line:
//!
//! 1. [`DistanceArg`], [`SpeedArg`], [`AccelArg`] and [`JerkArg`] read the text while clap parses: a number
//!    without rounding, and a unit.
//! 2. [`SpeedArg::resolve`] turns it into what the core holds, by the motor's
//!    [`Geometry`] ([`GeometryArgs`]), rounding **once**, and keeps the text, so
//!    that a [`Rounded`] can show what was understood: `120rpm → 400 steps/s`.

mod decimal;
mod distance;
mod machine_unit;
mod unit;

use std::ffi::OsString;
use std::fmt::{self, Display};
use std::ops::RangeInclusive;
use std::str::FromStr;

use stepwright::{Accel, Geometry, Jerk, Speed};

use crate::failure::Failure;
use decimal::Decimal;
pub use distance::DistanceArg;
use machine_unit::TURN;
pub use machine_unit::{MachineUnit, in_unit};
use unit::{Kind, Unit};

/// The steps that a turn may have.
pub const STEPS_PER_REV: RangeInclusive<u32> = 1..=10_000_000;

/// A range as clap takes it.
pub const fn bounds(range: RangeInclusive<u32>) -> RangeInclusive<i64> {
    *range.start() as i64..=*range.end() as i64
}

/// The options that say how a motor's steps relate to the world.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Motor")]
pub struct GeometryArgs {
    /// Steps of one turn, microsteps included: 200 for 1.8°, 3200 with 1/16 [default: 200]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u32).range(bounds(STEPS_PER_REV)))]
    steps_per_rev: Option<u32>,
    /// Millimetres that the load travels in one turn; needed for mm/s
    #[arg(long, value_name = "MM")]
    mm_per_rev: Option<MmArg>,
}

impl GeometryArgs {
    /// What is known of a motor.
    pub fn new(steps_per_rev: Option<u32>, mm_per_rev: Option<MmArg>) -> GeometryArgs {
        GeometryArgs { steps_per_rev, mm_per_rev }
    }

    /// Of a motor whose turn moves its load by this many millimetres.
    pub fn leading(steps_per_rev: u32, mm: f64) -> GeometryArgs {
        let nm = (mm * 1e6).round();
        // Beyond 4 m a turn there are no millimetres.
        let nm = (1.0..=f64::from(u32::MAX)).contains(&nm).then_some(MmArg(nm as u32));
        GeometryArgs { steps_per_rev: Some(steps_per_rev), mm_per_rev: nm }
    }

    /// These, and those of another motor where there are none.
    pub fn or(&self, other: &GeometryArgs) -> GeometryArgs {
        GeometryArgs {
            steps_per_rev: self.steps_per_rev.or(other.steps_per_rev),
            mm_per_rev: self.mm_per_rev.or(other.mm_per_rev),
        }
    }

    /// What the core makes of them.
    pub fn geometry(&self) -> Result<Geometry, Failure> {
        let geometry = Geometry::new(self.steps_per_rev.unwrap_or(TURN))?;
        Ok(match self.mm_per_rev {
            Some(MmArg(nm)) => geometry.travelling_nm(nm)?,
            None => geometry,
        })
    }
}

impl GeometryArgs {
    /// The unit of a machine that is built so.
    pub fn unit(&self) -> Option<MachineUnit> {
        MachineUnit::of(self.steps_per_rev, self.mm_per_rev.map(|MmArg(nm)| nm))
    }

    /// The unit that the page shows positions in, and the steps of one: millimetres where the
    /// load moves along a line.
    pub fn page_unit(&self) -> Result<(&'static str, f64), Failure> {
        self.geometry()?;
        let millimetres = self.unit().filter(|_| self.mm_per_rev.is_some());
        Ok(millimetres.map_or(("steps", 1.0), |unit| (unit.name, unit.steps)))
    }
}

/// A distance in millimetres, held in whole nanometres.
#[derive(Clone, Copy, Debug)]
pub struct MmArg(u32);

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

/// A number with its unit, and the text it was read from.
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
                _ => "it begins with a number, like 1000 or 120rpm".into(),
            });
        }
        let unit = unit.trim();
        if unit.starts_with(',') {
            return Err("write a decimal point, and nothing between thousands".into());
        }
        let (number, unit) = (Decimal::parse(number)?, Unit::parse(unit, kind)?);
        Ok(Quantity { text: text.to_owned(), number, unit })
    }

    /// Whether it is nothing at all.
    fn is_zero(&self) -> bool {
        self.number.to_f64() == 0.0
    }

    fn no_millimetres(&self, name: &str) -> Failure {
        Failure::usage(format!("{name} {}: millimetres need the distance of one turn", self.text))
            .hint("add --mm-per-rev, for example --mm-per-rev 40 for a GT2 belt on 20 teeth")
    }

    /// In thousandths of a step; `name` is the option, for the message.
    fn resolve<T>(
        &self,
        geometry: &Geometry,
        name: &str,
        kind: Kind,
        core: impl FnOnce(u64) -> Result<T, Failure>,
    ) -> Result<Rounded<T>, Failure> {
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

/// What was typed, and what the core holds of it.
///
/// Shows as `400 steps/s`, `120rpm → 400 steps/s`, or, when it was rounded to
/// a thousandth of a step, `10rad/s ≈ 318.31 steps/s`.
#[derive(Clone, Debug)]
pub struct Rounded<T> {
    /// What the core holds.
    pub value: T,
    /// What was typed.
    pub given: String,
    /// Whether nothing was lost.
    pub exact: bool,
    per: &'static str,
    converted: bool,
}

impl<T> Rounded<T> {
    /// Whether it was typed in another unit than steps.
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

/// A speed without a sign, as typed: for clap's `#[arg]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SpeedArg(Quantity);

impl FromStr for SpeedArg {
    type Err = String;

    fn from_str(text: &str) -> Result<SpeedArg, String> {
        Quantity::parse(text, Kind::Speed).map(SpeedArg)
    }
}

impl SpeedArg {
    /// Of this many steps/s.
    pub fn of_steps(number: u32) -> SpeedArg {
        let text = number.to_string();
        SpeedArg(Quantity { text, number: Decimal::whole(number), unit: Unit::STEP })
    }

    /// In steps per second, not rounded, for what is not ordered but used in a calculation
    /// with; `name` is the option that it came from.
    pub fn steps(&self, geometry: &Geometry, name: &str) -> Result<f64, Failure> {
        let Quantity { number, unit, .. } = &self.0;
        let steps = unit.steps(number.to_f64(), geometry);
        steps.ok_or_else(|| self.0.no_millimetres(name))
    }

    /// As it was typed.
    pub fn given(&self) -> &str {
        &self.0.text
    }

    /// In steps per second; `name` is the option that it came from.
    pub fn resolve(&self, geometry: &Geometry, name: &str) -> Result<Rounded<Speed>, Failure> {
        self.held(geometry, name, "0")
    }

    /// In steps per second, more than 0; `name` is the option that it came from.
    pub fn moving(&self, geometry: &Geometry, name: &str) -> Result<Rounded<Speed>, Failure> {
        self.held(geometry, name, "0.001")
    }

    /// From `least` steps/s, 0 or 0.001.
    fn held(
        &self,
        geometry: &Geometry,
        name: &str,
        least: &str,
    ) -> Result<Rounded<Speed>, Failure> {
        self.0.resolve(geometry, name, Kind::Speed, |milli| {
            let speed = u32::try_from(milli).ok().and_then(|m| Speed::from_millisteps(m).ok());
            let speed = speed.filter(|speed| least == "0" || *speed != Speed::ZERO);
            speed.ok_or_else(|| self.beyond(name, least))
        })
    }

    fn beyond(&self, name: &str, least: &str) -> Failure {
        let text = &self.0.text;
        Failure::usage(format!("{name} must be {least} to 1,000,000 steps/s, not {text}")).hint(
            if self.0.is_zero() {
                "0 is no motion; `stepwright stop` brakes a motor that runs"
            } else {
                "are the unit and --steps-per-rev right?"
            },
        )
    }
}

/// A speed whose sign is a direction: `+1000`, `1000`, `-120rpm`.
///
/// clap takes `-120rpm` for an option: see [`words`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SignedSpeedArg {
    /// Forward, unless it began with a minus.
    pub forward: bool,
    /// How fast.
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

/// The words of a command line as clap can read them: a number and the unit that was typed
/// behind it with a space are one word, and `-120rpm` and `-.5mm` have a minus (U+2212) in
/// place of the hyphen, which clap takes for the beginning of an option.
pub fn words(typed: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut words: Vec<OsString> = Vec::new();
    for word in typed {
        match words.last_mut() {
            Some(last) if is_number(last) && word.to_str().is_some_and(unit::is_known) => {
                last.push(word);
            }
            _ => words.push(word),
        }
    }
    words.into_iter().map(minus).collect()
}

/// Whether a word is a number without a unit.
fn is_number(word: &OsString) -> bool {
    let Some(word) = word.to_str() else { return false };
    let size = word.strip_prefix(['-', '+', '\u{2212}']).unwrap_or(word);
    !size.is_empty() && Decimal::length(size) == size.len()
}

fn minus(word: OsString) -> OsString {
    match word.to_str().and_then(|word| word.strip_prefix('-')) {
        Some(rest) if rest.starts_with(|c: char| c == '.' || c.is_ascii_digit()) => {
            // What clap can read by itself stays as it is.
            if rest.parse::<f64>().is_ok() { word } else { format!("\u{2212}{rest}").into() }
        }
        _ => word,
    }
}

/// An acceleration without a sign, as typed: for clap's `#[arg]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AccelArg(Quantity);

impl FromStr for AccelArg {
    type Err = String;

    fn from_str(text: &str) -> Result<AccelArg, String> {
        Quantity::parse(text, Kind::Accel).map(AccelArg)
    }
}

impl AccelArg {
    /// In steps per second squared; `name` is the option that it came from.
    pub fn resolve(&self, geometry: &Geometry, name: &str) -> Result<Rounded<Accel>, Failure> {
        self.0.resolve(geometry, name, Kind::Accel, |milli| {
            Accel::from_millisteps(milli).map_err(|_| {
                Failure::usage(if milli == 0 {
                    format!("{name} {} is less than 0.001 steps/s²", self.0.text)
                } else {
                    format!("{name} {} is more than 100000000 steps/s²", self.0.text)
                })
                .hint(
                    "an acceleration is 0.001 to 100000000 steps/s²; for none at all, \
                       set --start-speed to the top speed",
                )
            })
        })
    }
}

/// A jerk without a sign, as typed: for clap's `#[arg]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JerkArg(Quantity);

impl FromStr for JerkArg {
    type Err = String;

    fn from_str(text: &str) -> Result<JerkArg, String> {
        Quantity::parse(text, Kind::Jerk).map(JerkArg)
    }
}

impl JerkArg {
    /// Whether it is 0: where a jerk may be left out, none at all.
    pub fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    /// In steps per second cubed; `name` is the option that it came from.
    pub fn resolve(&self, geometry: &Geometry, name: &str) -> Result<Rounded<Jerk>, Failure> {
        self.0.resolve(geometry, name, Kind::Jerk, |milli| {
            Jerk::from_millisteps(milli).map_err(|_| {
                Failure::usage(if milli == 0 {
                    format!("{name} {} is less than 0.001 steps/s³", self.0.text)
                } else {
                    format!("{name} {} is more than 1000000000000000 steps/s³", self.0.text)
                })
                .hint(
                    "a jerk is 0.001 to 10^15 steps/s³; for none at all, use \
                     stepwright plan trapezoid",
                )
            })
        })
    }
}

#[cfg(test)]
mod tests;
