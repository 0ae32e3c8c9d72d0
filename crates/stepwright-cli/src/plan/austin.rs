//! `plan austin`: Austin's constant acceleration.

use clap::ValueEnum;
use stepwright::{Geometry, Rate};
use stepwright_austin::{Austin, Divisor};

use super::change::{self, Change, ChangeArg, Changed, Changing, changes};
use super::counted::Counted;
use super::formula::{At, Formula, Ramps, Turns};
use super::law::{Law, Plan};
use super::limits::{Asked, Begin, First, Limits};
use super::{Common, Planned};
use crate::failure::Failure;
use crate::figures::law::{next, next_simple, turning_point};

/// Austin's ramp: each delay from the one before (Eq 12 to 19)
///
/// The motor starts and ends at rest. Down goes the ramp of the deceleration;
/// steps that rounding leaves over are travelled at the speed reached. On its way
/// up it may change its acceleration.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  Figures 2 to 4 of the article, 0 to 120 rpm in a second:
    stepwright plan austin --steps 1000 --accel 12.566rad/s2 --top-speed 120rpm
  The same with an exact first step, as a table:
    stepwright plan austin --steps 1000 --accel 12.566rad/s2 --top-speed 120rpm \\
      --c0 c1 --format table
  Quick to start and gentle to stop, as a picture:
    stepwright plan austin --steps 1000 --accel 2000 --decel 500 --top-speed 1000 \\
      --plot ramp.png
  A ramp that changes its acceleration twice on its way (Eq 18):
    stepwright plan austin --steps 2000 --accel 1000 --top-speed 1500 \\
      --change 100:3000 --change 300:500 --plot changes.png")]
pub struct Args {
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    begin: Begin,
    /// What the change of a step is divided by; c/2n has a first delay of its own
    #[arg(long, value_enum, default_value_t = Divide::FourN, conflicts_with = "c0")]
    divisor: Divide,
    /// Another acceleration after this many steps, like 100:500; any number of them
    #[arg(long = "change", value_name = "STEPS:ACCEL", conflicts_with = "divisor")]
    changes: Vec<ChangeArg>,
    #[command(flatten)]
    common: Common,
}

/// For clap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Divide {
    /// 2c/(4n+1), Eq 12
    #[value(name = "4n+1")]
    FourN,
    /// c/2n, the article's variant: the first delay is √π/2 of the exact one
    #[value(name = "2n")]
    TwoN,
}

impl Planned for Args {
    fn common(&self) -> &Common {
        &self.common
    }

    fn plan(&self, rate: Rate, geometry: &Geometry) -> Result<Plan, Failure> {
        let asked = self.limits.held(rate, geometry)?;
        let mut values = asked.values();
        let first = asked.motor().c0(asked.accels().0);
        let mut begin = self.begin.c0.value(self.begin.c0.counts(first).0);
        if self.divisor == Divide::TwoN {
            let held = first * ROOT_PI / 2.0;
            let shown = format!("{held:.2} ticks (0.886 of Eq 7; changes of c/2n)");
            begin = super::law::Value { shown, given: "2n".into(), held, ..begin };
        }
        values.push(begin);
        let changes = changes(&self.changes, geometry)?;
        values.extend(change::values(&changes));
        let law = match changes.is_empty() {
            true => law(&asked, self.begin.c0, self.divisor)?,
            false => changing(&asked, self.begin.c0, &changes)?,
        };
        Plan::new("austin", asked.rate, geometry, values, law)
    }
}

const ROOT_PI: f64 = 1.772_453_850_905_516;

/// The law for these limits.
pub fn law(asked: &Asked, c0: First, divisor: Divide) -> Result<Box<dyn Law>, Failure> {
    let (accel, decel) = (asked.accel.value, asked.decel.value);
    let two = divisor == Divide::TwoN;
    let core = Austin::new(asked.rate, asked.top.value, accel)
        .with_decel(decel)
        .with_c0(c0.core())
        .with_divisor(if two { Divisor::TwoN } else { Divisor::FourN });
    let delays = core.delays(asked.steps)?;

    let motor = asked.motor();
    let (accel, decel) = asked.accels();
    let exact = motor.c0(accel);
    let first = if two { (exact * ROOT_PI / 2.0, exact * ROOT_PI / 2.0) } else { c0.counts(exact) };
    let least = motor.delay(asked.speed()).max(1.0);
    let ramps = Plain { two };
    let turns = ramps.turns(asked.steps, first.1, least, accel, decel);
    let formula = Formula::new(Box::new(ramps), asked.steps, first, least, turns);
    Ok(Box::new(Counted::new(delays, formula, asked.rate, "")))
}

/// The law that changes on its way.
fn changing(asked: &Asked, c0: First, changes: &[Change]) -> Result<Box<dyn Law>, Failure> {
    let core = Austin::new(asked.rate, asked.top.value, asked.accel.value)
        .with_decel(asked.decel.value)
        .with_c0(c0.core());
    let delays = Changed::new(core.delays(asked.steps)?, changes);
    let motor = asked.motor();
    let (accel, decel) = asked.accels();
    let first = c0.counts(motor.c0(accel));
    let least = motor.delay(asked.speed()).max(1.0);
    let ramps = Changing::new(accel, decel, changes);
    let turns = ramps.turns(asked.steps, first.1, least);
    let formula = Formula::new(Box::new(ramps), asked.steps, first, least, turns);
    Ok(Box::new(Counted::new(delays, formula, asked.rate, "")))
}

/// Eq 12 and 14, or their variant.
pub struct Plain {
    /// c/2n.
    pub two: bool,
}

impl Plain {
    /// Up until the top speed or the turning point (Eq 19); J by Eq 18, rounded.
    fn turns(&self, pulses: u32, c: f64, least: f64, accel: f64, decel: f64) -> Turns {
        let m = f64::from(pulses);
        let half = if self.two { 0.25 } else { 0.5 };
        // As one fraction of whole numbers, so that halves are halves.
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
