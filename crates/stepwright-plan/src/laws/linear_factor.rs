//! Austin's recommended transition: a linear factor.

use stepwright_austin::LinearFactor;

use super::counted::Counted;
use super::formula::{At, Formula, Ramps, Turns};
use crate::PlanError;
use crate::asked::{First, PlanLimits};
use crate::equations::{next_scaled, turning_point};
use crate::law::{PlanValue, PlannedLaw};
use crate::watch::Watch;

/// The corners as a line of the summary.
pub(crate) fn knee(limits: &PlanLimits, c0: First, knee: u16) -> Result<PlanValue, PlanError> {
    let corners = core(limits, c0, knee).corners(limits.steps)?;
    let part = f64::from(knee) / 1e3;
    Ok(PlanValue {
        name: "knee",
        shown: format!(
            "{part} of the top speed: n1 = {}, n2 = {}, n3 = {}",
            corners.n1,
            corners.n2,
            corners.n3(limits.steps)
        ),
        given: part.to_string(),
        held: part,
        unit: "of the top speed",
    })
}

fn core(limits: &PlanLimits, c0: First, knee: u16) -> LinearFactor {
    LinearFactor::new(limits.rate, limits.top.value, limits.accel.value)
        .with_decel(limits.decel.value)
        .with_c0(c0.core())
        .with_knee(knee)
}

/// The law for these limits.
pub(crate) fn law(
    limits: &PlanLimits,
    c0: First,
    knee: u16,
    watch: Watch<'_>,
) -> Result<Box<dyn PlannedLaw>, PlanError> {
    let delays = core(limits, c0, knee).delays(limits.steps)?;
    let first = c0.counts(limits.motor().c0(limits.accels().0));
    let least = limits.motor().delay(limits.speed()).max(1.0);
    let (factor, turns) = corners(limits, c0, f64::from(knee) / 1e3);
    let formula = Formula::new(Box::new(factor), limits.steps, first, least, turns, watch);
    let short = "Eq 23 estimates it so";
    Ok(Box::new(Counted::new(delays, formula, limits.rate, short)))
}

/// n₁ and n₂ of the way up, j₁ and j₂ of the way down.
struct Factor {
    up: (f64, f64),
    down: (f64, f64),
}

fn corners(limits: &PlanLimits, c0: First, knee: f64) -> (Factor, Turns) {
    let (motor, top, m) = (limits.motor(), limits.speed(), f64::from(limits.steps));
    let transition = |accel: f64| {
        let accel = accel * c0.part();
        let n1 = motor.step_of(knee * top, accel).round();
        match n1 > 0.0 {
            true => (n1, motor.transition(accel, n1, top).map_or(n1 + 1.0, f64::floor)),
            false => (0.0, motor.transition_from_rest(accel, top).max(1.0)),
        }
    };
    let (accel, decel) = limits.accels();
    let (mut up, mut down) = (transition(accel), transition(decel));
    let complete = up.1 + down.1 <= m || m < 2.0;
    if !complete {
        let short = turning_point(m, accel, decel).round().clamp(1.0, m - 1.0);
        let scaled = |(n1, n2): (f64, f64), n: f64| ((n1 * n / n2).round().min(n - 1.0), n);
        (up, down) = (scaled(up, short), scaled(down, m - short));
    }
    down.0 = down.0.max(1.0);
    // If n₃ = n₂, this step belongs to the way down.
    let (last, steps) = (up.1.min(m - down.1 - 1.0), down.1.min(m));
    (Factor { up, down }, Turns { up: last as u32, down: steps as u32, complete })
}

impl Ramps for Factor {
    fn faster(&self, at: &mut At) {
        at.i += 1;
        let (n, (n1, n2)) = (f64::from(at.i), self.up);
        at.c = next_scaled(at.c, n, if n <= n1 { 1.0 } else { (n2 - n) / (n2 - n1) });
    }

    fn slower(&self, c: f64, j: u32) -> f64 {
        let (j, (j1, j2)) = (f64::from(j), self.down);
        next_scaled(c, -j, if j <= j1 { 1.0 } else { (j2 - j) / (j2 - j1) })
    }
}
