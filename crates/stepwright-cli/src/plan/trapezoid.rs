//! `plan trapezoid`: constant acceleration, top speed, constant deceleration.

use stepwright::{Geometry, Rate};
use stepwright_plan::{LawChoice, Plan, Watch};

use super::limits::Limits;
use super::{Common, Planned};
use crate::failure::Failure;
use crate::quantity::{DistanceArg, SpeedArg};

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

    fn distance(&self) -> &DistanceArg {
        self.limits.distance()
    }

    fn plan(&self, rate: Rate, geometry: &Geometry, watch: Watch<'_>) -> Result<Plan, Failure> {
        let start = self.start_speed.resolve(geometry, "--start-speed")?;
        let limits = self.limits.held(rate, geometry)?;
        Ok(LawChoice::Trapezoid { start }.plan(&limits, geometry, watch)?)
    }
}
