//! Austin's constant acceleration.

use stepwright_austin::{Austin, Divisor};

use super::change::{Changed, Changing, RampChange};
use super::counted::Counted;
use super::formula::{At, Formula, Ramps, Turns};
use crate::PlanError;
use crate::asked::{Divide, First, PlanLimits, first_delay};
use crate::equations::{next, next_simple, turning_point};
use crate::law::{PlanValue, PlannedLaw};
use crate::watch::Watch;

const ROOT_PI: f64 = 1.772_453_850_905_516;

/// The first delay as a line of the summary.
pub(crate) fn begin(limits: &PlanLimits, c0: First, divisor: Divide) -> PlanValue {
    let first = limits.motor().c0(limits.accels().0);
    match divisor {
        Divide::FourN => c0.value(c0.counts(first).0, limits.least()),
        Divide::TwoN => {
            let how = "0.886 of Eq 7; changes of c/2n";
            first_delay("2n", how, first * ROOT_PI / 2.0, limits.least())
        }
    }
}

/// The law for these limits.
pub(crate) fn law(
    limits: &PlanLimits,
    c0: First,
    divisor: Divide,
    watch: Watch<'_>,
) -> Result<Box<dyn PlannedLaw>, PlanError> {
    let (accel, decel) = (limits.accel.value, limits.decel.value);
    let two = divisor == Divide::TwoN;
    let core = Austin::new(limits.rate, limits.top.value, accel)
        .with_decel(decel)
        .with_c0(c0.core())
        .with_divisor(if two { Divisor::TwoN } else { Divisor::FourN });
    let delays = core.delays(limits.steps)?;

    let motor = limits.motor();
    let (accel, decel) = limits.accels();
    let exact = motor.c0(accel);
    let first = if two { (exact * ROOT_PI / 2.0, exact * ROOT_PI / 2.0) } else { c0.counts(exact) };
    let least = motor.delay(limits.speed()).max(1.0);
    let ramps = Plain { two };
    let turns = ramps.turns(limits.steps, first.1, least, accel, decel);
    let formula = Formula::new(Box::new(ramps), limits.steps, first, least, turns, watch);
    Ok(Box::new(Counted::new(delays, formula, limits.rate, "")))
}

/// The law with changes of acceleration on the way up.
pub(crate) fn changing(
    limits: &PlanLimits,
    c0: First,
    changes: &[RampChange],
    watch: Watch<'_>,
) -> Result<Box<dyn PlannedLaw>, PlanError> {
    let core = Austin::new(limits.rate, limits.top.value, limits.accel.value)
        .with_decel(limits.decel.value)
        .with_c0(c0.core());
    let delays = Changed::new(core.delays(limits.steps)?, changes);
    let motor = limits.motor();
    let (accel, decel) = limits.accels();
    let first = c0.counts(motor.c0(accel));
    let least = motor.delay(limits.speed()).max(1.0);
    let ramps = Changing::new(accel, decel, changes);
    let turns = ramps.turns(limits.steps, first.1, least);
    let formula = Formula::new(Box::new(ramps), limits.steps, first, least, turns, watch);
    Ok(Box::new(Counted::new(delays, formula, limits.rate, "")))
}

/// The ramps of Eq 12 and 14, or of their variant.
pub(crate) struct Plain {
    /// Whether changes are c/2n.
    pub two: bool,
}

impl Plain {
    /// Up to the top speed or the turning point (Eq 19); J by Eq 18, rounded.
    fn turns(&self, pulses: u32, c: f64, least: f64, accel: f64, decel: f64) -> Turns {
        let m = f64::from(pulses);
        let half = if self.two { 0.25 } else { 0.5 };
        // As one fraction of whole numbers, so that halves are exact.
        let down = |n: f64| {
            let (a, d) = ((accel * 1e3).round(), (decel * 1e3).round());
            (((n + half) * a + (0.5 - half) * d) / d).floor()
        };
        let mut turn = turning_point(m, accel, decel).floor();
        while turn > 0.0 && turn + 1.0 + down(turn) > m {
            turn -= 1.0;
        }
        let mut at = At { c, ..At::default() };
        while at.c > least && f64::from(at.i) < turn {
            self.faster(&mut at);
        }
        Turns { up: at.i, down: down(at.i.into()) as u32, complete: at.c <= least }
    }
}

impl Ramps for Plain {
    fn faster(&self, at: &mut At) {
        at.i += 1;
        at.c = if self.two { next_simple(at.c, at.i.into()) } else { next(at.c, at.i.into()) };
    }

    fn slower(&self, c: f64, j: u32) -> f64 {
        let j = f64::from(j);
        if self.two { c + c / (2.0 * j - 1.0) } else { next(c, -j) }
    }
}
