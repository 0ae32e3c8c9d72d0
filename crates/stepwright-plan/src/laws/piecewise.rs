//! Austin's piecewise linear transition.

use stepwright_austin::Piecewise;

use super::counted::Counted;
use super::formula::{At, Formula, Ramps, shadow};
use crate::PlanError;
use crate::asked::{First, PlanLimits};
use crate::equations::next;
use crate::law::{PlanValue, PlannedLaw};
use crate::watch::Watch;

/// The breaks as a line of the summary.
pub(crate) fn stages(breaks: u8) -> PlanValue {
    let last = 1.375f64.powi(breaks.into()).recip() * 100.0;
    PlanValue {
        name: "breaks",
        shown: format!("{breaks}: {last:.3} % of the acceleration is left at the last"),
        given: breaks.to_string(),
        held: breaks.into(),
        unit: "",
    }
}

/// The law for these limits.
pub(crate) fn law(
    limits: &PlanLimits,
    c0: First,
    breaks: u8,
    watch: Watch<'_>,
) -> Result<Box<dyn PlannedLaw>, PlanError> {
    let delays = Piecewise::new(limits.rate, limits.top.value, limits.accel.value)
        .with_decel(limits.decel.value)
        .with_c0(c0.core())
        .with_breaks(breaks)
        .delays(limits.steps)?;

    let motor = limits.motor();
    let (accel, decel) = limits.accels();
    let least = motor.delay(limits.speed()).max(1.0);
    let at = |accel| At { c: c0.counts(motor.c0(accel)).1, ..At::default() };
    let mut stages = Stages { levels: levels(least, breaks), down: vec![(0, 0.0)] };
    let (levels, mut down) = (stages.levels.clone(), Vec::new());
    let up = |at: &mut At| stages.faster(at);
    let follow = |at: &mut At| {
        let before = at.crossed;
        step(&levels, at);
        if at.crossed > before {
            // A step that was tried without success is tried a second time.
            down.retain(|(i, _)| *i < at.i);
            down.push((at.i, at.n));
        }
    };
    let turns = shadow(limits.steps, least, at(accel), at(decel), up, follow, watch);
    stages.down.append(&mut down);
    let first = c0.counts(motor.c0(accel));
    let formula = Formula::new(Box::new(stages), limits.steps, first, least, turns, watch);
    Ok(Box::new(Counted::new(delays, formula, limits.rate, "")))
}

/// The delays of the breaks, each half way between the break before and the top speed.
fn levels(least: f64, breaks: u8) -> Vec<f64> {
    let next = |c: &f64| Some((c + least) / 2.0);
    std::iter::successors(Some(3.0 * least), next).skip(1).take(breaks.into()).collect()
}

/// Goes one step up. Several breaks within one step apply one after the other.
fn step(levels: &[f64], at: &mut At) {
    at.i += 1;
    at.n += 1.0;
    while levels.get(at.crossed).is_some_and(|level| at.c <= *level) {
        at.n *= 1.375;
        at.crossed += 1;
    }
    at.c = next(at.c, at.n);
}

struct Stages {
    levels: Vec<f64>,
    /// Steps of the ramp down at which n was multiplied, and n from these steps on.
    down: Vec<(u32, f64)>,
}

impl Ramps for Stages {
    fn faster(&self, at: &mut At) {
        step(&self.levels, at);
    }

    fn slower(&self, c: f64, j: u32) -> f64 {
        let stage = self.down.partition_point(|(from, _)| *from <= j);
        let (from, n) = self.down.get(stage.saturating_sub(1)).copied().unwrap_or((0, 0.0));
        next(c, -(n + f64::from(j - from)))
    }
}
