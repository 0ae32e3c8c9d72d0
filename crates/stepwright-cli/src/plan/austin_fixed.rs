//! `plan austin-fixed`: Austin's published listing.

use stepwright::{Geometry, Rate};
use stepwright_plan::{Plan, Watch};

use super::{Common, Planned, Steps};
use crate::failure::Failure;
use crate::quantity::{DistanceArg, whole_in};

/// Austin's ramp as it was published: fixed point, 24.8, delay for delay
///
/// The first delay sets the acceleration, the shortest the top speed; the
/// deceleration is the same. The error that the summary shows is that of the
/// listing's truncating divisions against Eq 12.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  The demo of the article, five turns of a 1.8° motor:
    stepwright plan austin-fixed --steps 1000 --c0 50000 --c-min 2500
  Its delays:
    stepwright plan austin-fixed --steps 10 --c0 50000 --c-min 2500 --format csv")]
pub struct Args {
    #[command(flatten)]
    steps: Steps,
    /// The first delay, in ticks, 1 to 2147483647
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = whole_in::<u32>(1..=0x7FFF_FFFF))]
    c0: u32,
    /// The shortest delay, in ticks, 1 to 2147483647
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = whole_in::<u32>(1..=0x7FFF_FFFF))]
    c_min: u32,
    #[command(flatten)]
    common: Common,
}

impl Planned for Args {
    fn common(&self) -> &Common {
        &self.common
    }

    fn distance(&self) -> &DistanceArg {
        &self.steps.steps
    }

    fn plan(&self, rate: Rate, geometry: &Geometry, watch: Watch<'_>) -> Result<Plan, Failure> {
        let steps = self.steps.held(geometry)?;
        Ok(Plan::austin_fixed(rate, geometry, steps, (self.c0, self.c_min), watch)?)
    }
}
