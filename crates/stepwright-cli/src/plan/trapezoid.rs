//! `plan trapezoid`: constant acceleration, top speed, constant deceleration.

use stepwright::profile::Trapezoid;
use stepwright::{Geometry, Rate};

use super::law::{Plan, Value};
use super::path::PathLaw;
use super::{Common, Steps, check_peak};
use crate::failure::Failure;
use crate::quantity::{AccelArg, SpeedArg};

/// Constant acceleration to a top speed, and constant deceleration
///
/// The motor starts and ends at the start speed. When the travel is too short
/// for the top speed, the two ramps meet below it.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  Five turns of a 1.8° motor, from rest to 120 rpm and back:
    stepwright plan trapezoid --steps 1000 --accel 12.566rad/s2 --top-speed 120rpm
  The same as a picture:
    stepwright plan trapezoid --steps 1000 --accel 12.566rad/s2 --top-speed 120rpm \\
      --plot ramp.png
  The first delays on a 16 MHz timer:
    stepwright plan trapezoid --steps 4000 --accel 2000 --top-speed 1000 \\
      --timer-hz 16000000 --format csv | head
  A belt of 40 mm a turn, quick to start and gentle to stop:
    stepwright plan trapezoid --steps 3200 --steps-per-rev 3200 --mm-per-rev 40 \\
      --accel 500mm/s2 --decel 250mm/s2 --top-speed 50mm/s")]
pub struct Args {
    #[command(flatten)]
    steps: Steps,
    /// Acceleration: 2000, 12.566rad/s2, 300rpm/s … (a bare number is steps/s²)
    #[arg(long, value_name = "ACCEL", allow_hyphen_values = true)]
    accel: AccelArg,
    /// Deceleration, if it differs
    #[arg(long, value_name = "ACCEL", allow_hyphen_values = true)]
    decel: Option<AccelArg>,
    /// Top speed: 1000, 120rpm, 10rad/s … (a bare number is steps/s)
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    top_speed: SpeedArg,
    /// Speed that the motor jumps to and stops from
    #[arg(long, value_name = "SPEED", default_value = "0", allow_hyphen_values = true)]
    start_speed: SpeedArg,
    #[command(flatten)]
    common: Common,
}

impl Args {
    /// What every law takes.
    pub fn common(&self) -> &Common {
        &self.common
    }

    /// The travel, and what was understood.
    pub fn plan(&self, rate: Rate, geometry: &Geometry) -> Result<Plan, Failure> {
        let start = self.start_speed.resolve(geometry, "--start-speed")?;
        let top = self.top_speed.resolve(geometry, "--top-speed")?;
        let accel = self.accel.resolve(geometry, "--accel")?;
        let decel = self.decel.as_ref().map(|d| d.resolve(geometry, "--decel")).transpose()?;
        let slower = decel.as_ref().map_or(accel.value, |d| d.value);

        let law = Trapezoid::new(rate, start.value, top.value, accel.value).with_decel(slower);
        let (path, delays) = (law.path(self.steps.get())?, law.delays(self.steps.get())?);
        let law = PathLaw::new(path, delays, rate, start.value, top.value);
        check_peak(&law, rate)?;

        Ok(Plan {
            name: "trapezoid",
            rate,
            steps_per_turn: geometry.steps_per_turn(),
            note: super::no_ramp(start.value, top.value),
            values: vec![
                Value::speed("start speed", &start),
                Value::speed("top speed", &top),
                Value::accel("acceleration", &accel),
                Value::accel("deceleration", decel.as_ref().unwrap_or(&accel)),
            ],
            law: Box::new(law),
        })
    }
}
