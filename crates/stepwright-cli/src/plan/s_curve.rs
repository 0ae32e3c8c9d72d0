//! `plan s-curve`: an acceleration that comes and goes at a limited jerk.

use stepwright::profile::{Curve, Fit, SCurve, Tracer};
use stepwright::run::Steps as Single;
use stepwright::{Geometry, Rate, Run, Ticks};

use super::bends::{Bends, Order};
use super::law::{Law, Plan, Span, Value};
use super::real::Real;
use super::{Common, Steps, check_peak};
use crate::failure::Failure;
use crate::quantity::{AccelArg, JerkArg, SpeedArg};

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
    steps: Steps,
    /// Acceleration: 2000, 12.566rad/s2, 300rpm/s … (a bare number is steps/s²)
    #[arg(long, value_name = "ACCEL", allow_hyphen_values = true)]
    accel: AccelArg,
    /// Deceleration, if it differs
    #[arg(long, value_name = "ACCEL", allow_hyphen_values = true)]
    decel: Option<AccelArg>,
    /// Top speed: 1000, 120rpm, 10rad/s … (a bare number is steps/s)
    #[arg(long, value_name = "SPEED", allow_hyphen_values = true)]
    top_speed: SpeedArg,
    /// How fast both change: 80000, 200rad/s3, 60rpm/s2 … (a bare number is steps/s³)
    #[arg(long, value_name = "JERK", allow_hyphen_values = true)]
    jerk: JerkArg,
    /// Speed that the motor jumps to and stops from
    #[arg(long, value_name = "SPEED", default_value = "0", allow_hyphen_values = true)]
    start_speed: SpeedArg,
    #[command(flatten)]
    common: Common,
}

impl Args {
    /// What every law takes.
    pub fn common(&self) -> &Common {
        &self.common
    }

    /// The travel, and what was understood.
    pub fn plan(&self, rate: Rate, geometry: &Geometry) -> Result<Plan, Failure> {
        let start = self.start_speed.resolve(geometry, "--start-speed")?;
        let top = self.top_speed.resolve(geometry, "--top-speed")?;
        let accel = self.accel.resolve(geometry, "--accel")?;
        let decel = self.decel.as_ref().map(|d| d.resolve(geometry, "--decel")).transpose()?;
        let jerk = self.jerk.resolve(geometry, "--jerk")?;
        let slower = decel.as_ref().map_or(accel.value, |d| d.value);

        let order = Order {
            rate,
            start: start.value,
            top: top.value,
            accel: accel.value,
            decel: slower,
            jerk: jerk.value,
            pulses: self.steps.get(),
        };
        let law = CurveLaw::new(&order)?;
        check_peak(&law, rate)?;

        Ok(Plan {
            name: "s-curve",
            rate,
            steps_per_turn: geometry.steps_per_turn(),
            note: super::no_ramp(start.value, top.value),
            values: vec![
                Value::speed("start speed", &start),
                Value::speed("top speed", &top),
                Value::accel("acceleration", &accel),
                Value::accel("deceleration", decel.as_ref().unwrap_or(&accel)),
                Value::jerk("jerk", &jerk),
            ],
            law: Box::new(law),
        })
    }
}

/// A curve beside its ideal.
pub struct CurveLaw {
    curve: Curve,
    ideal: Bends,
    start: f64,
}

impl CurveLaw {
    /// The core's curve, to be measured against one of the same values.
    pub fn new(order: &Order) -> Result<CurveLaw, Failure> {
        let Order { rate, start, top, accel, decel, jerk, pulses } = *order;
        let law = SCurve::new(rate, start, top, accel, jerk).with_decel(decel);
        let start = f64::from(start.min(top).millisteps()) / 1000.0;
        Ok(CurveLaw { curve: law.curve(pulses)?, ideal: Bends::new(order), start })
    }
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

    fn runs(&self, fit: Fit) -> Box<dyn Iterator<Item = Run> + '_> {
        Box::new(Tracer::new(self.curve, fit))
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
