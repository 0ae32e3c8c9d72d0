//! `plan power`: Austin's power term.

use stepwright::{Geometry, Rate};
use stepwright_plan::{LawChoice, Plan, Watch};

use super::limits::{Begin, Limits};
use super::{Common, Planned};
use crate::failure::Failure;
use crate::quantity::{DistanceArg, whole_in};

/// Acceleration that a power of the step number ends (Eq 20, 21)
///
/// The speed approaches the top speed asymptotically: the first half of a travel accelerates,
/// the second decelerates, and with the power 2 a travel of usual length stays far below the
/// top speed.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  A sharper and a softer knee:
    stepwright plan power --steps 2000 --accel 2000 --top-speed 1000 --power 5
    stepwright plan power --steps 2000 --accel 2000 --top-speed 1000 --power 3")]
pub struct Args {
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    begin: Begin,
    #[command(flatten)]
    power: Power,
    #[command(flatten)]
    common: Common,
}

/// How sharp the knee is.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Power {
    /// Exponent p of the power term, 2 to 9: the higher, the sharper the knee
    #[arg(long, value_name = "P", default_value_t = 4, allow_negative_numbers = true)]
    #[arg(value_parser = whole_in::<u8>(2..=9))]
    pub power: u8,
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
        let law = LawChoice::Power { c0: self.begin.c0, power: self.power.power };
        Ok(law.plan(&limits, geometry, watch)?)
    }
}
