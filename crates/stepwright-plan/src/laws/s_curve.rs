//! Ramps with a limited jerk.

use stepwright::profile::{Curve, Fit, SCurve, Tracer};
use stepwright::run::Steps as Single;
use stepwright::{Jerk, Run, Speed, Ticks};
use stepwright_oracle::{Double, IdealSCurve, JerkLimits, Number};

use crate::PlanError;
use crate::asked::PlanLimits;
use crate::law::{Closeness, PlannedLaw, Span};

/// The law for these limits.
pub(crate) fn law(
    limits: &PlanLimits,
    start: Speed,
    jerk: Jerk,
) -> Result<Box<dyn PlannedLaw>, PlanError> {
    let PlanLimits { rate, steps, ref accel, ref decel, ref top } = *limits;
    let (accel, decel, top) = (accel.value, decel.value, top.value);
    let law = SCurve::new(rate, start, top, accel, jerk).with_decel(decel);
    // In thousandths of a step, so that all values are whole numbers.
    let ideal = JerkLimits {
        start: Double::whole(start.millisteps().into()),
        top: Double::whole(top.millisteps().into()),
        accel: Double::whole(accel.millisteps()),
        decel: Double::whole(decel.millisteps()),
        jerk: Double::whole(jerk.millisteps()),
    };
    let length = Double::whole(1000 * u64::from(steps.saturating_sub(1)));
    let start = f64::from(start.min(top).millisteps()) / 1000.0;
    Ok(Box::new(CurveLaw {
        curve: law.curve(steps)?,
        ideal: IdealSCurve::new(ideal, length),
        hz: Double::whole(rate.hz().into()),
        start,
    }))
}

/// A curve and its ideal.
struct CurveLaw {
    curve: Curve,
    ideal: IdealSCurve<Double>,
    hz: Double,
    start: f64,
}

impl PlannedLaw for CurveLaw {
    fn pulses(&self) -> u32 {
        self.curve.pulses()
    }

    fn delays(&self) -> Box<dyn Iterator<Item = Ticks> + '_> {
        let first = (self.pulses() > 0).then_some(0);
        Box::new(first.into_iter().chain(Single::new(self.stretches())))
    }

    fn stretches(&self) -> Box<dyn Iterator<Item = Run> + '_> {
        Box::new(Tracer::new(self.curve, Fit::EXACT))
    }

    fn ideal(&self, n: u32) -> Double {
        self.ideal.time(Double::whole(1000 * u64::from(n))) * self.hz
    }

    fn spans(&self) -> Vec<Span> {
        self.curve.phases().map(|(phase, pulses)| Span { phase, pulses }).collect()
    }

    fn runs(&self, fit: Closeness) -> Box<dyn Iterator<Item = Run> + '_> {
        Box::new(Tracer::new(self.curve, fit.fit()))
    }

    fn ends(&self) -> f64 {
        self.start
    }

    fn peak(&self) -> f64 {
        if self.pulses() < 2 { 0.0 } else { self.ideal.peak().to_f64() / 1000.0 }
    }

    fn braking(&self) -> u32 {
        self.curve.braking_steps()
    }
}
