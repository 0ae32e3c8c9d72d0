//! The option for a change of the acceleration during a ramp (Eq 18).

use std::str::FromStr;

use stepwright::Geometry;
use stepwright_plan::RampChange;

use crate::failure::Failure;
use crate::quantity::AccelArg;

/// A new acceleration of a ramp, and the step after which it begins.
#[derive(Clone, Debug)]
pub struct ChangeArg {
    steps: u32,
    accel: AccelArg,
}

impl FromStr for ChangeArg {
    type Err = String;

    fn from_str(text: &str) -> Result<ChangeArg, String> {
        let (steps, accel) = text.split_once(':').ok_or("give STEPS:ACCEL, like 100:500")?;
        let steps: u32 = steps.parse().map_err(|_| "STEPS is a whole number, like 100")?;
        if steps == 0 {
            return Err("a ramp changes after 1 step or more".into());
        }
        Ok(ChangeArg { steps, accel: accel.parse()? })
    }
}

/// The changes of a ramp in the order of their steps.
pub fn changes(args: &[ChangeArg], geometry: &Geometry) -> Result<Vec<RampChange>, Failure> {
    let held = |change: &ChangeArg| Ok((change.steps, change.accel.resolve(geometry, "--change")?));
    let mut all: Vec<RampChange> = args.iter().map(held).collect::<Result<_, Failure>>()?;
    all.sort_by_key(|(steps, _)| *steps);
    if let Some(twice) = all.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(Failure::usage(format!("two --change after {} steps", twice[0].0))
            .hint("give one of them"));
    }
    Ok(all)
}
