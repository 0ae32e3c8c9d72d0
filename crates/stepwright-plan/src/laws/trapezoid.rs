//! Constant acceleration, constant speed, constant deceleration.

use stepwright::Speed;
use stepwright::profile::Trapezoid;

use super::constant::ConstantLaw;
use crate::PlanError;
use crate::asked::PlanLimits;
use crate::law::PlannedLaw;

/// The law for these limits.
pub(crate) fn law(limits: &PlanLimits, start: Speed) -> Result<Box<dyn PlannedLaw>, PlanError> {
    let PlanLimits { rate, steps, ref accel, ref decel, ref top } = *limits;
    let law = Trapezoid::new(rate, start, top.value, accel.value).with_decel(decel.value);
    let (path, delays) = (law.path(steps)?, law.delays(steps)?);
    Ok(Box::new(ConstantLaw::new(path, delays, rate, start, top.value)))
}
