//! The options of every law with an acceleration and a top speed.

use stepwright::{Geometry, Rate};
use stepwright_plan::PlanLimits;

use super::Steps;
use crate::failure::Failure;
use crate::quantity::{AccelArg, DistanceArg, SpeedArg};

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
    /// The distance, as typed.
    pub fn distance(&self) -> &DistanceArg {
        &self.steps.steps
    }

    /// The limits, rounded to what the core can represent.
    pub fn held(&self, rate: Rate, geometry: &Geometry) -> Result<PlanLimits, Failure> {
        let accel = self.accel.resolve(geometry, "--accel")?;
        let decel = self.decel.as_ref().map(|d| d.resolve(geometry, "--decel")).transpose()?;
        let top = self.top_speed.moving(geometry, "--top-speed")?;
        let decel = decel.unwrap_or_else(|| accel.clone());
        Ok(PlanLimits { rate, steps: self.steps.held(geometry)?, accel, decel, top })
    }
}
