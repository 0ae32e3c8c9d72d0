//! `plan trapezoid`: constant acceleration, top speed, constant deceleration.

use stepwright::profile::Trapezoid;
use stepwright::{Geometry, Rate, Speed};

use super::law::{Law, Plan, Value};
use super::limits::{Asked, Limits};
use super::path::PathLaw;
use super::{Common, Planned};
use crate::failure::Failure;
use crate::quantity::SpeedArg;

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
    limits: Limits,
    /// Speed that the motor jumps to and stops from
    #[arg(long, value_name = "SPEED", default_value = "0", allow_hyphen_values = true)]
    start_speed: SpeedArg,
    #[command(flatten)]
    common: Common,
}

impl Planned for Args {
    fn common(&self) -> &Common {
        &self.common
    }

    fn plan(&self, rate: Rate, geometry: &Geometry) -> Result<Plan, Failure> {
        let start = self.start_speed.resolve(geometry, "--start-speed")?;
        let asked = self.limits.held(rate, geometry)?;
        let mut values = asked.values();
        values.insert(0, Value::speed("start speed", &start));
        let law = law(&asked, start.value)?;
        let plan = Plan::new("trapezoid", asked.rate, geometry, values, law)?;
        Ok(Plan { note: super::no_ramp(start.value, asked.top.value), ..plan })
    }
}

/// The law for these limits.
pub fn law(asked: &Asked, start: Speed) -> Result<Box<dyn Law>, Failure> {
    let Asked { rate, steps, ref accel, ref decel, ref top } = *asked;
    let law = Trapezoid::new(rate, start, top.value, accel.value).with_decel(decel.value);
    let (path, delays) = (law.path(steps)?, law.delays(steps)?);
    Ok(Box::new(PathLaw::new(path, delays, rate, start, top.value)))
}
