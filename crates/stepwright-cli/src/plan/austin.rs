//! `plan austin`: Austin's constant acceleration.

use stepwright::{Geometry, Rate};
use stepwright_plan::{Divide, LawChoice, Plan, Watch};

use super::change::{ChangeArg, changes};
use super::limits::{Begin, Limits};
use super::{Common, Planned};
use crate::failure::Failure;
use crate::quantity::DistanceArg;

/// Austin's ramp: each delay from the one before (Eq 12 to 19)
///
/// The motor starts and ends at rest. Steps that the rounding of the ramp down leaves over
/// are made at the speed reached. The acceleration may change during the ramp up.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  Figures 2 to 4 of the article, 0 to 120 rpm in a second:
    stepwright plan austin --steps 1000 --accel 12.566rad/s2 --top-speed 120rpm
  The same with an exact first step, as a table:
    stepwright plan austin --steps 1000 --accel 12.566rad/s2 --top-speed 120rpm \\
      --c0 c1 --format table
  Quick to start and gentle to stop, as a picture:
    stepwright plan austin --steps 1000 --accel 2000 --decel 500 --top-speed 1000 \\
      --plot ramp.png
  A ramp that changes its acceleration twice on its way (Eq 18):
    stepwright plan austin --steps 2000 --accel 1000 --top-speed 1500 \\
      --change 100:3000 --change 300:500 --plot changes.png")]
pub struct Args {
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    begin: Begin,
    /// Divisor of the change from one delay to the next; c/2n has a first delay of its own
    #[arg(long, value_enum, default_value_t = Divide::FourN, conflicts_with = "c0")]
    divisor: Divide,
    /// Change the acceleration after this many steps, like 100:500; any number of times
    #[arg(long = "change", value_name = "STEPS:ACCEL", conflicts_with = "divisor")]
    changes: Vec<ChangeArg>,
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
        let limits = self.limits.held(rate, geometry)?;
        let changes = changes(&self.changes, geometry)?;
        let law = LawChoice::Austin { c0: self.begin.c0, divisor: self.divisor, changes };
        Ok(law.plan(&limits, geometry, watch)?)
    }
}
