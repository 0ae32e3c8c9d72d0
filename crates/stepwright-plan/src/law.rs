//! The interface of a ramp law for the outputs, and a plan made with it.
//!
//! Each law is one file in `laws/`. The trait answers all that the summary, the tables, the runs and the
//! plots need.

use stepwright::profile::{Fit, Phase};
use stepwright::{Accel, Geometry, Jerk, Rate, Run, Speed, Ticks};
use stepwright_oracle::Double;
use stepwright_units::Rounded;

use crate::PlanError;

/// A travel by a ramp law.
pub trait PlannedLaw {
    /// The number of pulses.
    fn pulses(&self) -> u32;

    /// The delay before each pulse as the core emits it; 0 before the first.
    fn delays(&self) -> Box<dyn Iterator<Item = Ticks> + '_>;

    /// The delays as runs that are played one after the other. Large travels take seconds step by step, but
    /// no time run by run.
    fn stretches(&self) -> Box<dyn Iterator<Item = Run> + '_> {
        Box::new(self.delays().skip(1).map(|delay| Run::steady(delay, 1)))
    }

    /// The ideal time of pulse `n`, counted from 0: in ticks after the first, from the values as held, and
    /// **not** by the core's own arithmetic.
    fn ideal(&self, n: u32) -> Double;

    /// The phases in their order, without gaps and without empty ones. They change between stretches.
    fn spans(&self) -> Vec<Span>;

    /// The runs that a board would get.
    fn runs(&self, fit: Closeness) -> Box<dyn Iterator<Item = Run> + '_>;

    /// Speed at the first and the last pulse, in steps/s.
    fn ends(&self) -> f64;

    /// The highest speed, in steps/s.
    fn peak(&self) -> f64;

    /// Why the peak stays below the top speed, if it does.
    fn short(&self) -> &'static str {
        "the travel is too short"
    }

    /// Whether the law leaves out the last delay of the formula: the motor would be at rest one step after
    /// the last pulse, not on it.
    fn holds(&self) -> bool {
        false
    }

    /// The number of steps while braking.
    fn braking(&self) -> u32;
}

/// How closely runs follow a law.
#[derive(Clone, Copy, Debug)]
pub struct Closeness {
    /// Largest error of a step, in ticks, at least 1.
    pub error: Ticks,
    /// The longest run of a law in closed form, in ticks.
    pub longest: Ticks,
}

impl Closeness {
    /// As the tolerance of a profile.
    pub fn fit(self) -> Fit {
        Fit::within(self.error, self.longest)
    }
}

/// A phase, and its number of pulses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The phase.
    pub phase: Phase,
    /// Its pulses.
    pub pulses: u32,
}

/// An ordered value as the core holds it.
#[derive(Clone, Debug)]
pub struct PlanValue {
    /// `top speed`
    pub name: &'static str,
    /// `120rpm → 400 steps/s`
    pub shown: String,
    /// As typed: `120rpm`
    pub given: String,
    /// 400
    pub held: f64,
    /// `steps/s`
    pub unit: &'static str,
}

impl PlanValue {
    /// A held distance.
    pub fn distance(held: &Rounded<i64>) -> PlanValue {
        let (shown, given) = (held.to_string(), held.given.clone());
        PlanValue { name: "distance", shown, given, held: held.value as f64, unit: "steps" }
    }

    /// A held speed.
    pub(crate) fn speed(name: &'static str, held: &Rounded<Speed>) -> PlanValue {
        let value = f64::from(held.value.millisteps()) / 1000.0;
        let (shown, given) = (held.to_string(), held.given.clone());
        PlanValue { name, shown, given, held: value, unit: "steps/s" }
    }

    /// A held acceleration.
    pub(crate) fn accel(name: &'static str, held: &Rounded<Accel>) -> PlanValue {
        let value = held.value.millisteps() as f64 / 1000.0;
        let (shown, given) = (held.to_string(), held.given.clone());
        PlanValue { name, shown, given, held: value, unit: "steps/s²" }
    }

    /// A held jerk.
    pub(crate) fn jerk(name: &'static str, held: &Rounded<Jerk>) -> PlanValue {
        let value = held.value.millisteps() as f64 / 1000.0;
        let (shown, given) = (held.to_string(), held.given.clone());
        PlanValue { name, shown, given, held: value, unit: "steps/s³" }
    }
}

/// A plan: a law with its values.
pub struct Plan {
    /// The law's name, as on the command line.
    pub name: &'static str,
    /// The step timer's rate.
    pub rate: Rate,
    /// Steps of one turn, for the output.
    pub steps_per_turn: u32,
    /// The values as understood.
    pub values: Vec<PlanValue>,
    /// A note for the reader.
    pub note: Option<String>,
    /// The law.
    pub law: Box<dyn PlannedLaw>,
}

impl Plan {
    /// A plan without a note.
    ///
    /// # Errors
    /// [`PlanError::TooFast`]: no timer can make two pulses in one tick.
    pub fn new(
        name: &'static str,
        rate: Rate,
        geometry: &Geometry,
        values: Vec<PlanValue>,
        law: Box<dyn PlannedLaw>,
    ) -> Result<Plan, PlanError> {
        let (peak, hz) = (law.peak(), rate.hz());
        if peak > f64::from(hz) {
            return Err(PlanError::TooFast { peak, hz });
        }
        let steps_per_turn = geometry.steps_per_turn();
        Ok(Plan { name, rate, steps_per_turn, values, note: None, law })
    }

    /// All pulses, one at a time.
    pub fn rows(&self) -> PlanRows<'_> {
        PlanRows {
            delays: self.law.delays(),
            spans: self.law.spans().into_iter(),
            span: Span { phase: Phase::Cruise, pulses: 0 },
            step: 0,
            time: 0,
        }
    }

    /// Speed in the row of a pulse: timer rate ÷ delay. The first pulse has no delay: its speed is the
    /// start speed.
    pub fn speed(&self, row: &PlanRow) -> f64 {
        if row.step == 1 {
            self.law.ends()
        } else {
            f64::from(self.rate.hz()) / f64::from(row.delay)
        }
    }

    /// The ordered top speed, if the travel never reaches it.
    pub fn short_of(&self) -> Option<f64> {
        let top = self.values.iter().find(|value| value.name == "top speed")?.held;
        (self.law.pulses() > 1 && self.law.peak() < top * (1.0 - 1e-9)).then_some(top)
    }

    /// Ticks in seconds.
    pub fn seconds(&self, ticks: f64) -> f64 {
        ticks / f64::from(self.rate.hz())
    }
}

/// One pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanRow {
    /// The number, counted from 1.
    pub step: u32,
    /// Ticks since the pulse before; 0 for the first.
    pub delay: Ticks,
    /// Ticks since the first pulse.
    pub time: u64,
    /// The phase of the interval that ends at this pulse.
    pub phase: Phase,
}

/// The pulses of a [`Plan`].
pub struct PlanRows<'a> {
    delays: Box<dyn Iterator<Item = Ticks> + 'a>,
    spans: std::vec::IntoIter<Span>,
    span: Span,
    step: u32,
    time: u64,
}

impl Iterator for PlanRows<'_> {
    type Item = PlanRow;

    fn next(&mut self) -> Option<PlanRow> {
        let delay = self.delays.next()?;
        while self.span.pulses == 0 {
            self.span = self.spans.next()?;
        }
        self.span.pulses -= 1;
        self.step += 1;
        self.time += u64::from(delay);
        Some(PlanRow { step: self.step, delay, time: self.time, phase: self.span.phase })
    }
}
