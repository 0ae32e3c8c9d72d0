//! `plan piecewise`: Austin's piecewise linear transition.

use stepwright::{Geometry, Rate};
use stepwright_austin::Piecewise;

use super::counted::Counted;
use super::formula::{At, Formula, Ramps, shadow};
use super::law::{Law, Plan, Value};
use super::limits::{Asked, Begin, First, Limits};
use super::{Common, Planned};
use crate::failure::Failure;
use crate::figures::law::next;

/// Acceleration that is reduced in stages near the top speed (Figure 5)
///
/// Breaks lie at 2, 1.5, 1.25 … times the shortest delay; each divides the
/// acceleration by 1.375.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  Seven breaks, as in the article:
    stepwright plan piecewise --steps 2000 --accel 2000 --top-speed 1000
  Three:
    stepwright plan piecewise --steps 2000 --accel 2000 --top-speed 1000 --breaks 3")]
pub struct Args {
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    begin: Begin,
    #[command(flatten)]
    breaks: Breaks,
    #[command(flatten)]
    common: Common,
}

/// How many stages.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Breaks {
    /// Breaks, 0 to 16: where the acceleration is reduced
    #[arg(long, value_name = "N", default_value_t = 7, allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u8).range(0..=16))]
    pub breaks: u8,
}

impl Planned for Args {
    fn common(&self) -> &Common {
        &self.common
    }

    fn plan(&self, rate: Rate, geometry: &Geometry) -> Result<Plan, Failure> {
        let asked = self.limits.held(rate, geometry)?;
        let mut values = asked.values();
        let first = asked.motor().c0(asked.accels().0);
        values.push(self.begin.c0.value(self.begin.c0.counts(first).0));
        let breaks = self.breaks.breaks;
        let last = 1.375f64.powi(breaks.into()).recip() * 100.0;
        values.push(Value {
            name: "breaks",
            shown: format!("{breaks}: {last:.3} % of the acceleration is left at the last"),
            given: breaks.to_string(),
            held: breaks.into(),
            unit: "",
        });
        let law = law(&asked, self.begin.c0, self.breaks)?;
        Plan::new("piecewise", asked.rate, geometry, values, law)
    }
}

/// The law for these limits.
pub fn law(asked: &Asked, c0: First, Breaks { breaks }: Breaks) -> Result<Box<dyn Law>, Failure> {
    let delays = Piecewise::new(asked.rate, asked.top.value, asked.accel.value)
        .with_decel(asked.decel.value)
        .with_c0(c0.core())
        .with_breaks(breaks)
        .delays(asked.steps)?;

    let motor = asked.motor();
    let (accel, decel) = asked.accels();
    let least = motor.delay(asked.speed()).max(1.0);
    let at = |accel| At { c: c0.counts(motor.c0(accel)).1, ..At::default() };
    let mut stages = Stages { levels: levels(least, breaks), down: vec![(0, 0.0)] };
    let (levels, mut down) = (stages.levels.clone(), Vec::new());
    let up = |at: &mut At| stages.faster(at);
    let follow = |at: &mut At| {
        let before = at.crossed;
        step(&levels, at);
        if at.crossed > before {
            // A step that was tried without success is tried again.
            down.retain(|(i, _)| *i < at.i);
            down.push((at.i, at.n));
        }
    };
    let turns = shadow(asked.steps, least, at(accel), at(decel), up, follow);
    stages.down.append(&mut down);
    let first = c0.counts(motor.c0(accel));
    let formula = Formula::new(Box::new(stages), asked.steps, first, least, turns);
    Ok(Box::new(Counted::new(delays, formula, asked.rate, "")))
}

/// Where the breaks lie: half way between the one before and the top speed.
fn levels(least: f64, breaks: u8) -> Vec<f64> {
    let next = |c: &f64| Some((c + least) / 2.0);
    std::iter::successors(Some(3.0 * least), next).skip(1).take(breaks.into()).collect()
}

/// One step up; several breaks in one count one after the other.
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
    /// Steps of the ramp down at which n was multiplied, and n from there on.
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
