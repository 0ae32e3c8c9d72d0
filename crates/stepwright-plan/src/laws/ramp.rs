//! A ramp given in steps, as the serial line orders it.

use stepwright::profile::RampSteps;
use stepwright::{Geometry, Rate, Speed};
use stepwright_units::Rounded;

use super::constant::ConstantLaw;
use crate::PlanError;
use crate::law::{Plan, PlanValue};

impl Plan {
    /// A travel whose ramps have this many steps each. The motor jumps to the start speed, accelerates
    /// constantly to the top speed, and brakes over its last steps.
    ///
    /// # Errors
    /// [`PlanError::Unfit`], [`PlanError::TooFast`]
    pub fn ramp(
        rate: Rate,
        geometry: &Geometry,
        steps: u32,
        start: &Rounded<Speed>,
        top: &Rounded<Speed>,
        ramp: u16,
    ) -> Result<Plan, PlanError> {
        let law = RampSteps::new(rate, start.value, top.value, ramp)?;
        let (path, delays) = (law.path(steps)?, law.delays(steps)?);
        let (slope, _) = path.slopes();
        let law = ConstantLaw::new(path, delays, rate, start.value, top.value);
        let note = super::no_ramp(start.value, top.value);
        let mut values =
            vec![PlanValue::speed("start speed", start), PlanValue::speed("top speed", top)];
        if note.is_none() {
            values.push(slope_of(ramp, slope, start.value.millisteps(), top.value.millisteps()));
        }
        let plan = Plan::new("ramp", rate, geometry, values, Box::new(law))?;
        Ok(Plan { note, ..plan })
    }
}

/// R and the resulting acceleration. `slope` is 2a in 10⁻⁶ (steps/s)².
fn slope_of(steps: u16, slope: u64, start: u32, top: u32) -> PlanValue {
    let square = |v: u32| u64::from(v) * u64::from(v);
    let exact = slope.checked_mul(steps.into()) == Some(square(top) - square(start));
    let accel = slope as f64 / 2e6;
    let sign = if exact { '→' } else { '≈' };
    PlanValue {
        name: "ramp",
        shown: format!("{steps} steps {sign} {accel} steps/s²"),
        given: steps.to_string(),
        held: accel,
        unit: "steps/s²",
    }
}
