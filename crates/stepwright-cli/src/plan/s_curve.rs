//! `plan s-curve`: an acceleration that comes and goes at a limited jerk.

use stepwright::profile::{Curve, Fit, SCurve, Tracer};
use stepwright::run::Steps as Single;
use stepwright::{Geometry, Jerk, Rate, Run, Speed, Ticks};

use super::bends::{Bends, Order};
use super::law::{Closeness, Law, Plan, Span, Value};
use super::limits::{Asked, Limits};
use super::real::Real;
use super::{Common, Planned};
use crate::failure::Failure;
use crate::quantity::{JerkArg, SpeedArg};

/// Acceleration and deceleration that come and go smoothly: a limited jerk
///
/// Phases: jerk-up (the acceleration grows), up, jerk-down (it goes back),
/// cruise, and the same for braking: jerk-up, down, jerk-down. What a short
/// travel or a small jerk leaves no time for is left out; it is the fastest
/// travel within the limits.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  From rest to 1000 steps/s and back, with 4000 steps/s² after 50 ms:
    stepwright plan s-curve --steps 2000 --accel 4000 --top-speed 1000 --jerk 80000
  The same as a picture:
    stepwright plan s-curve --steps 2000 --accel 4000 --top-speed 1000 --jerk 80000 \\
      --plot s-curve.png
  Five turns of a 1.8° motor, quick to start and gentle to stop:
    stepwright plan s-curve --steps 1000 --accel 20rad/s2 --decel 10rad/s2 \\
      --jerk 200rad/s3 --top-speed 120rpm
  What a board would get for it:
    stepwright plan s-curve --steps 4000 --accel 20000 --top-speed 5000 --jerk 400000 \\
      --timer-hz 16000000 --runs")]
pub struct Args {
    #[command(flatten)]
    limits: Limits,
    /// How fast both change: 80000, 200rad/s3, 60rpm/s2 … (a bare number is steps/s³)
    #[arg(long, value_name = "JERK", allow_hyphen_values = true)]
    jerk: JerkArg,
    /// Speed that the motor jumps to and stops from
    #[arg(long, value_name = "SPEED", default_value = "0", allow_hyphen_values = true)]
    start_speed: SpeedArg,
    #[command(flatten)]
    common: Common,
}

impl Planned for Args {
    fn common(&self) -> &Common {
        &self.common
    }

    fn plan(&self, rate: Rate, geometry: &Geometry) -> Result<Plan, Failure> {
        let start = self.start_speed.resolve(geometry, "--start-speed")?;
        let asked = self.limits.held(rate, geometry)?;
        let jerk = self.jerk.resolve(geometry, "--jerk")?;
        let mut values = asked.values();
        values.insert(0, Value::speed("start speed", &start));
        values.push(Value::jerk("jerk", &jerk));
        let law = law(&asked, start.value, jerk.value)?;
        let plan = Plan::new("s-curve", asked.rate, geometry, values, law)?;
        Ok(Plan { note: super::no_ramp(start.value, asked.top.value), ..plan })
    }
}

/// The law for these limits.
pub fn law(asked: &Asked, start: Speed, jerk: Jerk) -> Result<Box<dyn Law>, Failure> {
    let Asked { rate, steps, ref accel, ref decel, ref top } = *asked;
    let (accel, decel, top) = (accel.value, decel.value, top.value);
    let law = SCurve::new(rate, start, top, accel, jerk).with_decel(decel);
    let ideal = Bends::new(&Order { rate, start, top, accel, decel, jerk, pulses: steps });
    let start = f64::from(start.min(top).millisteps()) / 1000.0;
    Ok(Box::new(CurveLaw { curve: law.curve(steps)?, ideal, start }))
}

/// A curve beside its ideal.
struct CurveLaw {
    curve: Curve,
    ideal: Bends,
    start: f64,
}

impl Law for CurveLaw {
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

    fn ideal(&self, n: u32) -> Real {
        self.ideal.time(n)
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
        if self.pulses() < 2 { 0.0 } else { self.ideal.peak() }
    }

    fn braking(&self) -> u32 {
        self.curve.braking_steps()
    }
}
