//! Austin's power term.

use stepwright_austin::PowerTerm;

use super::counted::Counted;
use super::formula::{At, Formula, Ramps, Turns, shadow};
use crate::PlanError;
use crate::asked::{First, PlanLimits};
use crate::equations::next_power;
use crate::law::{PlanValue, PlannedLaw};
use crate::watch::Watch;

/// k and p as a line of the summary.
pub(crate) fn term(limits: &PlanLimits, c0: First, p: u8) -> PlanValue {
    let k = constant(limits, limits.accels().0 * c0.part(), p.into());
    PlanValue {
        name: "power term",
        shown: format!("k = {k:.4e}, p = {p}"),
        given: p.to_string(),
        held: k,
        unit: "",
    }
}

/// k by Eq 21. A top speed within the first step counts as the speed after one step.
fn constant(limits: &PlanLimits, accel: f64, p: i32) -> f64 {
    limits.motor().power(accel, limits.speed().max((2.0 * accel).sqrt()), p)
}

/// The law for these limits.
pub(crate) fn law(
    limits: &PlanLimits,
    c0: First,
    power: u8,
    watch: Watch<'_>,
) -> Result<Box<dyn PlannedLaw>, PlanError> {
    let delays = PowerTerm::new(limits.rate, limits.top.value, limits.accel.value, power)
        .with_decel(limits.decel.value)
        .with_c0(c0.core())
        .delays(limits.steps)?;

    let (motor, p) = (limits.motor(), i32::from(power));
    let (accel, decel) = limits.accels();
    let at = |accel| At { c: c0.counts(motor.c0(accel)).1, ..At::default() };
    let k = |accel| constant(limits, accel * c0.part(), p);
    let term = Term { p, up: k(accel), down: k(decel) };
    let least = motor.delay(limits.speed()).max(1.0);
    let up = |at: &mut At| term.faster(at);
    let down = |at: &mut At| Term { up: term.down, ..term }.faster(at);
    // The approach never ends, so no travel is too short for it.
    let turns = shadow(limits.steps, least, at(accel), at(decel), up, down, watch);
    let turns = Turns { complete: true, ..turns };
    let first = c0.counts(motor.c0(accel));
    let formula = Formula::new(Box::new(term), limits.steps, first, least, turns, watch);
    let short = "the approach is asymptotic";
    Ok(Box::new(Counted::new(delays, formula, limits.rate, short)))
}

/// p, and k of both ramps.
#[derive(Clone, Copy)]
struct Term {
    p: i32,
    up: f64,
    down: f64,
}

impl Ramps for Term {
    fn faster(&self, at: &mut At) {
        at.i += 1;
        at.c = next_power(at.c, at.i.into(), self.up, self.p);
    }

    fn slower(&self, c: f64, j: u32) -> f64 {
        let j = f64::from(j);
        c + 2.0 * c / (4.0 * j - 1.0 + self.down * j.powi(self.p))
    }
}
