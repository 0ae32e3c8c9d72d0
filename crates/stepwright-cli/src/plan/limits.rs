//! The options of every law with an acceleration and a top speed.

use clap::ValueEnum;
use stepwright::{Accel, Geometry, Rate, Speed};
use stepwright_austin::C0;

use super::Steps;
use super::law::Value;
use crate::failure::Failure;
use crate::figures::law::Motor;
use crate::quantity::{AccelArg, Rounded, SpeedArg};

/// How far, and within which limits.
#[derive(clap::Args)]
pub struct Limits {
    #[command(flatten)]
    steps: Steps,
    /// Acceleration: 2000, 12.566rad/s2, 300rpm/s … (a bare number is steps/s²)
    #[arg(long, value_name = "ACCEL", allow_hyphen_values = true)]
    accel: AccelArg,
    /// Deceleration, if it differs
    #[arg(long, value_name = "ACCEL", allow_hyphen_values = true)]
    decel: Option<AccelArg>,
    /// Top speed: 1000, 120rpm, 10rad/s … (a bare number is steps/s)
    #[arg(long, alias = "speed", value_name = "SPEED", allow_hyphen_values = true)]
    top_speed: SpeedArg,
}

impl Limits {
    /// What the core holds of them.
    pub fn held(&self, rate: Rate, geometry: &Geometry) -> Result<Asked, Failure> {
        let accel = self.accel.resolve(geometry, "--accel")?;
        let decel = self.decel.as_ref().map(|d| d.resolve(geometry, "--decel")).transpose()?;
        let top = self.top_speed.resolve(geometry, "--top-speed")?;
        let decel = decel.unwrap_or_else(|| accel.clone());
        Ok(Asked { rate, steps: self.steps.held(geometry)?, accel, decel, top })
    }
}

/// The limits of a travel as the core holds them.
#[derive(Clone, Debug)]
pub struct Asked {
    /// Of the step timer.
    pub rate: Rate,
    /// Pulses.
    pub steps: u32,
    /// Acceleration.
    pub accel: Rounded<Accel>,
    /// Deceleration; the same unless it was given.
    pub decel: Rounded<Accel>,
    /// Top speed.
    pub top: Rounded<Speed>,
}

impl Asked {
    /// For the summary.
    pub fn values(&self) -> Vec<Value> {
        vec![
            Value::speed("top speed", &self.top),
            Value::accel("acceleration", &self.accel),
            Value::accel("deceleration", &self.decel),
        ]
    }

    /// The timer and a motor whose angles are steps, for Austin's equations.
    pub fn motor(&self) -> Motor {
        Motor { hz: self.rate.hz().into(), step: 1.0 }
    }

    /// Top speed in steps/s.
    pub fn speed(&self) -> f64 {
        f64::from(self.top.value.millisteps()) / 1e3
    }

    /// Acceleration and deceleration in steps/s². An acceleration with which the
    /// very first step would be too fast to brake from is lowered, as the core
    /// does: to that which leaves J = m − ½ in Eq 18.
    pub fn accels(&self) -> (f64, f64) {
        let held = |a: &Rounded<Accel>| a.value.millisteps() as f64 / 1e3;
        let (accel, decel) = (held(&self.accel), held(&self.decel));
        (accel.min((2.0 * f64::from(self.steps.max(1)) - 1.0) * decel), decel)
    }
}

/// How one of Austin's ramps begins.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Begin {
    /// The first delay, which Eq 12 makes too much of
    #[arg(long, value_enum, default_value_t = First::Reduced)]
    pub c0: First,
}

/// For clap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum First {
    /// By Eq 7, as it is: all delays are too long, the acceleration is 0.457 of the one given
    Exact,
    /// 0.676 of it (Eq 15), as the article recommends
    #[value(name = "0.676")]
    Reduced,
    /// By Eq 7, and the second delay 0.4056 of it
    C1,
}

impl First {
    /// As the core has it.
    pub fn core(self) -> C0 {
        match self {
            First::Exact => C0::Exact,
            First::Reduced => C0::Reduced,
            First::C1 => C0::FirstStep,
        }
    }

    /// What is emitted, and what the formula goes on from, of an exact c₀.
    pub fn counts(self, exact: f64) -> (f64, f64) {
        match self {
            First::Exact => (exact, exact),
            First::Reduced => (0.676 * exact, 0.676 * exact),
            First::C1 => (exact, 0.676 * exact),
        }
    }

    /// The part of the acceleration that the ramp has in truth.
    pub fn part(self) -> f64 {
        if self == First::Exact { 0.676 * 0.676 } else { 1.0 }
    }

    /// For the summary: the first delay.
    pub fn value(self, ticks: f64) -> Value {
        let (given, how) = match self {
            First::Exact => ("exact", "Eq 7"),
            First::Reduced => ("0.676", "0.676 of Eq 7"),
            First::C1 => ("c1", "Eq 7; the second is 0.4056 of it"),
        };
        Value {
            name: "first delay",
            shown: format!("{ticks:.2} ticks ({how})"),
            given: given.into(),
            held: ticks,
            unit: "ticks",
        }
    }
}
