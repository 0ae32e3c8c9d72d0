//! `plan linear-factor`: Austin's recommended transition.

use stepwright::{Geometry, Rate};
use stepwright_plan::{LawChoice, Plan, Watch};

use super::limits::{Begin, Limits};
use super::{Common, Planned};
use crate::failure::Failure;
use crate::quantity::DistanceArg;

/// Acceleration that falls linearly to 0 at the top speed (Eq 22 to 25)
///
/// The ramp down mirrors this: a travel too short for the top speed goes from acceleration to
/// deceleration without a jump. The speed reached is the article's estimate, some tenths of a
/// per cent below the top speed.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  Figure 8 of the article:
    stepwright plan linear-factor --steps 700 --accel 10rad/s2 --decel 20rad/s2 \\
      --top-speed 10rad/s --plot figure-8.png
  The factor beginning at half of the top speed:
    stepwright plan linear-factor --steps 1000 --accel 2000 --top-speed 1000 --knee 0.5")]
pub struct Args {
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    begin: Begin,
    #[command(flatten)]
    knee: Knee,
    #[command(flatten)]
    common: Common,
}

/// Where the linear factor begins.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Knee {
    /// Speed where the acceleration begins to fall, as a part of the top speed: 0 to 0.9
    #[arg(long, value_name = "PART", default_value = "0", value_parser = thousandths)]
    #[arg(allow_negative_numbers = true)]
    pub knee: u16,
}

/// Parses a part from 0 to 0.9, in thousandths.
pub fn thousandths(text: &str) -> Result<u16, String> {
    let part: f64 = text.parse().map_err(|_| "give a part of the top speed, like 0.5")?;
    if (0.0..=0.9).contains(&part) {
        Ok((part * 1e3).round() as u16)
    } else {
        Err("it is 0 to 0.9".into())
    }
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
        let law = LawChoice::LinearFactor { c0: self.begin.c0, knee: self.knee.knee };
        Ok(law.plan(&limits, geometry, watch)?)
    }
}
