//! `plan ramp`: the Nano slave's ramp, counted in steps.

use stepwright::{Geometry, Rate};
use stepwright_plan::{Plan, Watch};

use super::{Common, Planned};
use crate::failure::Failure;
use crate::quantity::{DistanceArg, SpeedArg, whole_in};

/// A ramp of a given number of steps, as the serial line orders it (S, T, R, G)
///
/// The motor jumps to the start speed, accelerates constantly over R steps to
/// the top speed, and brakes over the last R steps.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  S5, T100, R200, G+4000 of the serial line:
    stepwright plan ramp --steps 4000 --start-speed 50 --top-speed 1000 --ramp 200
  What a board gets for it:
    stepwright plan ramp --steps 4000 --start-speed 50 --top-speed 1000 --ramp 200 \\
      --timer-hz 16000000 --runs")]
pub struct Args {
    /// Steps to travel, -2147483648 to 2147483647, as in G; the way back is planned like the way there
    #[arg(long, value_name = "±M", allow_negative_numbers = true)]
    steps: DistanceArg,
    /// Speed that the motor jumps to and stops from: 50, 15rpm …
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    start_speed: SpeedArg,
    /// Speed after the ramp: 1000, 120rpm … (a bare number is steps/s)
    #[arg(long, alias = "speed", value_name = "SPEED", allow_hyphen_values = true)]
    top_speed: SpeedArg,
    /// Steps between start and top speed, 1 to 65535
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    #[arg(value_parser = whole_in::<u16>(1..=u16::MAX))]
    ramp: u16,
    #[command(flatten)]
    common: Common,
}

impl Args {
    /// The number of steps of the travel, within the range of G.
    fn pulses(&self, geometry: &Geometry) -> Result<u32, Failure> {
        let held = self.steps.resolve(geometry, "--steps")?;
        let steps = i32::try_from(held.value).map(i32::unsigned_abs);
        steps.map_err(|_| {
            Failure::usage(format!("--steps {}: too far for one travel", held.given))
                .hint("a travel has at most 2147483647 steps forward, 2147483648 backward")
        })
    }
}

impl Planned for Args {
    fn common(&self) -> &Common {
        &self.common
    }

    fn distance(&self) -> &DistanceArg {
        &self.steps
    }

    fn plan(&self, rate: Rate, geometry: &Geometry, _: Watch<'_>) -> Result<Plan, Failure> {
        let start = self.start_speed.resolve(geometry, "--start-speed")?;
        let top = self.top_speed.moving(geometry, "--top-speed")?;
        let steps = self.pulses(geometry)?;
        Ok(Plan::ramp(rate, geometry, steps, &start, &top, self.ramp)?)
    }
}
