//! Walks over the laws of the core.

use stepwright::fixed::Q32;
use stepwright::profile::{Cursor, Fit, Phase, SCurve, Tracer, Trapezoid, Unfit};
use stepwright::{Run, Ticks};
use stepwright_austin::{Austin, Fixed, Law, LinearFactor, Piecewise, PowerTerm, Pulses};

use crate::ideal::{constant, s_curve as bent};
use crate::order::{PlanLaw, PlanOrder, PlanRefusal};
use crate::planner::{MOST_POINTS, Planner, Walk};

impl PlanLaw {
    /// Walks over the pulses of a travel by this law.
    pub(crate) fn walk(self, order: &PlanOrder, to: &mut Planner) -> Result<(), PlanRefusal> {
        let PlanOrder { rate, steps, top, accel, decel, c0, .. } = *order;
        match self {
            PlanLaw::Trapezoid => trapezoid(order, to)?,
            PlanLaw::SCurve => s_curve(order, to)?,
            PlanLaw::Austin => {
                let law = Austin::new(rate, top, accel).with_decel(decel).with_c0(c0);
                let law = law.with_divisor(order.divisor).constants(steps)?;
                counted(law.delays(steps), law.lead.max(law.shortest), order, to);
            }
            PlanLaw::AustinFixed => {
                if accel != decel {
                    return Err(Unfit::Uneven.into());
                }
                // Eq 15 and Eq 2, to the nearest tick, as the command moves a motor by this law.
                let law = Austin::new(rate, top, accel).with_c0(c0).constants(steps)?;
                let ticks = |delay: Q32| (delay.saturating_add(1 << 31) >> 32) as Ticks;
                listing(Fixed::new(steps, ticks(law.lead), ticks(law.shortest)), order, to);
            }
            PlanLaw::LinearFactor => {
                let law = LinearFactor::new(rate, top, accel).with_decel(decel).with_c0(c0);
                let law = law.with_knee(order.knee).constants(steps)?;
                counted(law.delays(steps), law.lead.max(law.shortest), order, to);
            }
            PlanLaw::Power => {
                let law = PowerTerm::new(rate, top, accel, order.power);
                let law = law.with_decel(decel).with_c0(c0).constants(steps)?;
                counted(law.delays(steps), law.lead.max(law.shortest), order, to);
            }
            PlanLaw::Piecewise => {
                let law = Piecewise::new(rate, top, accel).with_decel(decel).with_c0(c0);
                let law = law.with_breaks(order.breaks).constants(steps)?;
                counted(law.delays(steps), law.lead.max(law.shortest), order, to);
            }
        }
        Ok(())
    }
}

fn trapezoid(order: &PlanOrder, to: &mut Planner) -> Result<(), PlanRefusal> {
    let PlanOrder { rate, steps, start, top, accel, decel, .. } = *order;
    let path = Trapezoid::new(rate, start, top, accel).with_decel(decel).path(steps)?;
    fits(path.peak(), order)?;
    let ideal = constant(start, top, (accel, decel), steps);
    let hz = order.hz();
    let mut walk = Walk::constant(to, order);
    let level = steps.saturating_sub(path.braking_steps());
    let (mut n, mut before) = (0, 0.0);
    played(Cursor::new(path, Fit::EXACT), |delay, _| {
        n += 1;
        let due = ideal.time(n.into()) * hz;
        walk.pulse(delay, due - before, n >= level, |_| due);
        walk.measure(due);
        before = due;
    });
    walk.end(Some(ideal.peak()), None);
    Ok(())
}

fn s_curve(order: &PlanOrder, to: &mut Planner) -> Result<(), PlanRefusal> {
    let PlanOrder { rate, steps, start, top, accel, decel, jerk, .. } = *order;
    let curve = SCurve::new(rate, start, top, accel, jerk).with_decel(decel).curve(steps)?;
    fits(curve.peak(), order)?;
    let ideal = bent(start, top, (accel, decel), jerk, steps);
    let hz = order.hz();
    let mut walk = Walk::new(to, order, false);
    let level = steps.saturating_sub(curve.braking_steps());
    // The formula finds a root by trial: of a long travel only some thousand pulses are measured.
    let stride = steps / MOST_POINTS as u32 + 1;
    let due = |n: u32| ideal.time(n.into()) * hz;
    let mut n = 0;
    played(Tracer::new(curve, Fit::EXACT), |delay, exact| {
        n += 1;
        walk.pulse(delay, exact, n >= level, due);
        if n % stride == 0 {
            walk.measure(due(n));
        }
    });
    walk.end(Some(ideal.peak()), Some(0.0));
    Ok(())
}

/// No timer makes more than one pulse per tick.
fn fits(peak: u32, order: &PlanOrder) -> Result<(), PlanRefusal> {
    let fast = u64::from(peak) > 1000 * u64::from(order.rate.hz());
    if fast { Err(PlanRefusal::TOO_FAST) } else { Ok(()) }
}

/// Plays runs as an engine does. `seen` gets each delay in whole ticks, and unrounded.
fn played(runs: impl Iterator<Item = Run>, mut seen: impl FnMut(Ticks, f64)) {
    let mut part = 0u64;
    for run in runs {
        let mut interval = run.interval();
        for _ in 0..run.count() {
            part = part.wrapping_add(interval);
            seen((part >> 16) as Ticks, interval as f64 / 65_536.0);
            part &= 0xFFFF;
            interval = interval.wrapping_add_signed(run.add().into());
        }
    }
}

/// Converts 2⁻³² ticks to ticks.
fn ticks(delay: Q32) -> f64 {
    delay as f64 / 4_294_967_296.0
}

/// A law that computes each delay from the one before.
fn counted<L: Law>(mut pulses: Pulses<L>, lead: Q32, order: &PlanOrder, to: &mut Planner) {
    let mut walk = Walk::new(to, order, true);
    let mut due = 0.0;
    // The first pulse; the delay after it is the law's own `lead`.
    pulses.next();
    let mut first = Some(lead);
    while let Some(delay) = pulses.next() {
        let exact = ticks(match first.take() {
            Some(lead) => lead,
            None => pulses.unrounded(),
        });
        due += exact;
        walk.pulse(delay, exact, pulses.phase() == Phase::Down, |_| due);
        walk.measure(due);
    }
    walk.end(None, None);
}

/// The published listing, which rounds each delay separately.
fn listing(mut pulses: Fixed, order: &PlanOrder, to: &mut Planner) {
    let mut walk = Walk::new(to, order, true);
    let mut due = 0.0;
    pulses.next();
    while let Some(delay) = pulses.next() {
        let exact = ticks(pulses.unrounded());
        due += exact;
        walk.pulse(delay, exact, pulses.phase() == Phase::Down, |_| due);
        walk.measure(due);
    }
    walk.end(None, None);
}
