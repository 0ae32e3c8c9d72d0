//! `plan piecewise`: Austin's piecewise linear transition.

use stepwright::{Geometry, Rate};
use stepwright_plan::{LawChoice, Plan, Watch};

use super::limits::{Begin, Limits};
use super::{Common, Planned};
use crate::failure::Failure;
use crate::quantity::{DistanceArg, whole_in};

/// Acceleration that is reduced in stages near the top speed (Figure 5)
///
/// Breaks lie at 2, 1.5, 1.25 … times the shortest delay; each divides the
/// acceleration by 1.375.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  Seven breaks, as in the article:
    stepwright plan piecewise --steps 2000 --accel 2000 --top-speed 1000
  Three:
    stepwright plan piecewise --steps 2000 --accel 2000 --top-speed 1000 --breaks 3")]
pub struct Args {
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    begin: Begin,
    #[command(flatten)]
    breaks: Breaks,
    #[command(flatten)]
    common: Common,
}

/// How many stages.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Breaks {
    /// Breaks, 0 to 16: where the acceleration is reduced
    #[arg(long, value_name = "N", default_value_t = 7, allow_negative_numbers = true)]
    #[arg(value_parser = whole_in::<u8>(0..=16))]
    pub breaks: u8,
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
        let law = LawChoice::Piecewise { c0: self.begin.c0, breaks: self.breaks.breaks };
        Ok(law.plan(&limits, geometry, watch)?)
    }
}
