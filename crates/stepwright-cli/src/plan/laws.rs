//! The own options of each law with an acceleration and a top speed.

use stepwright::Geometry;
use stepwright_plan::{Divide, First, LawChoice};
use stepwright_units::UnitError;

use super::Choice;
use super::change::{ChangeArg, changes};
use crate::failure::Failure;
use crate::quantity::{JerkArg, SpeedArg, whole_in};

/// Constant acceleration.
#[derive(clap::Args)]
pub struct Trapezoid {
    /// Speed that the motor jumps to and stops from
    #[arg(long, value_name = "SPEED", default_value = "0", allow_hyphen_values = true)]
    start_speed: SpeedArg,
}

impl Choice for Trapezoid {
    fn choice(&self, geometry: &Geometry) -> Result<LawChoice, Failure> {
        let start = self.start_speed.resolve(geometry, "--start-speed")?;
        Ok(LawChoice::Trapezoid { start })
    }
}

/// A limited jerk.
#[derive(clap::Args)]
pub struct SCurve {
    /// Jerk limit: 80000, 200rad/s3, 60rpm/s2 … (a bare number is steps/s³)
    #[arg(long, value_name = "JERK", allow_hyphen_values = true)]
    jerk: JerkArg,
    /// Speed that the motor jumps to and stops from
    #[arg(long, value_name = "SPEED", default_value = "0", allow_hyphen_values = true)]
    start_speed: SpeedArg,
}

impl Choice for SCurve {
    fn choice(&self, geometry: &Geometry) -> Result<LawChoice, Failure> {
        let start = self.start_speed.resolve(geometry, "--start-speed")?;
        let jerk = self.jerk.resolve(geometry, "--jerk").map_err(|error| {
            let small = matches!(error, UnitError::Jerk { is_small: true, .. });
            let failure = Failure::from(error);
            if small {
                failure.hint("without a limit of it, use stepwright plan trapezoid")
            } else {
                failure
            }
        })?;
        Ok(LawChoice::SCurve { start, jerk })
    }
}

/// Austin's constant acceleration.
#[derive(clap::Args)]
pub struct Austin {
    #[command(flatten)]
    begin: Begin,
    /// Divisor of the change from one delay to the next; c/2n has a first delay of its own
    #[arg(long, value_enum, default_value_t = Divide::FourN, conflicts_with = "c0")]
    divisor: Divide,
    /// Change the acceleration after this many steps, like 100:500; any number of times
    #[arg(long = "change", value_name = "STEPS:ACCEL", conflicts_with = "divisor")]
    changes: Vec<ChangeArg>,
}

impl Choice for Austin {
    fn choice(&self, geometry: &Geometry) -> Result<LawChoice, Failure> {
        let (c0, divisor) = (self.begin.c0, self.divisor);
        Ok(LawChoice::Austin { c0, divisor, changes: changes(&self.changes, geometry)? })
    }
}

/// Austin's recommended transition.
#[derive(clap::Args)]
pub struct LinearFactor {
    #[command(flatten)]
    begin: Begin,
    #[command(flatten)]
    knee: Knee,
}

impl Choice for LinearFactor {
    fn choice(&self, _: &Geometry) -> Result<LawChoice, Failure> {
        Ok(LawChoice::LinearFactor { c0: self.begin.c0, knee: self.knee.knee })
    }
}

/// Austin's power term.
#[derive(clap::Args)]
pub struct PowerTerm {
    #[command(flatten)]
    begin: Begin,
    #[command(flatten)]
    power: Power,
}

impl Choice for PowerTerm {
    fn choice(&self, _: &Geometry) -> Result<LawChoice, Failure> {
        Ok(LawChoice::Power { c0: self.begin.c0, power: self.power.power })
    }
}

/// Austin's piecewise linear transition.
#[derive(clap::Args)]
pub struct Piecewise {
    #[command(flatten)]
    begin: Begin,
    #[command(flatten)]
    breaks: Breaks,
}

impl Choice for Piecewise {
    fn choice(&self, _: &Geometry) -> Result<LawChoice, Failure> {
        Ok(LawChoice::Piecewise { c0: self.begin.c0, breaks: self.breaks.breaks })
    }
}

/// How one of Austin's ramps begins.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Begin {
    /// The first delay; after the exact one, Eq 12 makes all delays too long
    #[arg(long, value_enum, default_value_t = First::Reduced)]
    pub c0: First,
}

/// Where the linear factor begins.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Knee {
    /// Speed where the acceleration begins to fall, as a part of the top speed: 0 to 0.9
    #[arg(long, value_name = "PART", default_value = "0", value_parser = thousandths)]
    #[arg(allow_negative_numbers = true)]
    pub knee: u16,
}

/// Parses a part from 0 to 0.9, in thousandths.
pub fn thousandths(text: &str) -> Result<u16, String> {
    let part: f64 = text.parse().map_err(|_| "give a part of the top speed, like 0.5")?;
    if (0.0..=0.9).contains(&part) {
        Ok((part * 1e3).round() as u16)
    } else {
        Err("it is 0 to 0.9".into())
    }
}

/// How sharp the knee is.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Power {
    /// Exponent p of the power term, 2 to 9: the higher, the sharper the knee
    #[arg(long, value_name = "P", default_value_t = 4, allow_negative_numbers = true)]
    #[arg(value_parser = whole_in::<u8>(2..=9))]
    pub power: u8,
}

/// How many stages.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Breaks {
    /// Breaks, 0 to 16: where the acceleration is reduced
    #[arg(long, value_name = "N", default_value_t = 7, allow_negative_numbers = true)]
    #[arg(value_parser = whole_in::<u8>(0..=16))]
    pub breaks: u8,
}
