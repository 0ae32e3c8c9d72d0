//! `plan s-curve`: ramps with a jerk limit.

use stepwright::{Geometry, Rate};
use stepwright_plan::{LawChoice, Plan, Watch};
use stepwright_units::UnitError;

use super::limits::Limits;
use super::{Common, Planned};
use crate::failure::Failure;
use crate::quantity::{DistanceArg, JerkArg, SpeedArg};

/// Acceleration and deceleration with limited jerk
///
/// Phases: jerk-up (the acceleration grows), up, jerk-down (it goes back),
/// cruise, and the same for braking: jerk-up, down, jerk-down. A short travel or a small
/// jerk leaves some phases out. The travel is the fastest within the limits.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  From rest to 1000 steps/s and back, with 4000 steps/s² after 50 ms:
    stepwright plan s-curve --steps 2000 --accel 4000 --top-speed 1000 --jerk 80000
  The same as a picture:
    stepwright plan s-curve --steps 2000 --accel 4000 --top-speed 1000 --jerk 80000 \\
      --plot s-curve.png
  Five turns of a 1.8° motor, quick to start and gentle to stop:
    stepwright plan s-curve --steps 1000 --accel 20rad/s2 --decel 10rad/s2 \\
      --jerk 200rad/s3 --top-speed 120rpm
  What a board would get for it:
    stepwright plan s-curve --steps 4000 --accel 20000 --top-speed 5000 --jerk 400000 \\
      --timer-hz 16000000 --runs")]
pub struct Args {
    #[command(flatten)]
    limits: Limits,
    /// Jerk limit: 80000, 200rad/s3, 60rpm/s2 … (a bare number is steps/s³)
    #[arg(long, value_name = "JERK", allow_hyphen_values = true)]
    jerk: JerkArg,
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
        let jerk = self.jerk.resolve(geometry, "--jerk").map_err(|error| {
            let small = matches!(error, UnitError::Jerk { is_small: true, .. });
            let failure = Failure::from(error);
            if small {
                failure.hint("without a limit of it, use stepwright plan trapezoid")
            } else {
                failure
            }
        })?;
        Ok(LawChoice::SCurve { start, jerk }.plan(&limits, geometry, watch)?)
    }
}
