//! `plan power`: Austin's power term.

use stepwright::{Geometry, Rate};
use stepwright_austin::PowerTerm;

use super::counted::Counted;
use super::formula::{At, Formula, Ramps, Turns, shadow};
use super::law::{Law, Plan, Value};
use super::limits::{Asked, Begin, First, Limits};
use super::{Common, Planned};
use crate::failure::Failure;
use crate::figures::law::next_power;

/// Acceleration that a power of the step number ends (Eq 20, 21)
///
/// The approach to the top speed is asymptotic: half of a travel goes up and half of it
/// down, and one of ordinary length with the power 2 falls far short.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  A sharper and a softer knee:
    stepwright plan power --steps 2000 --accel 2000 --top-speed 1000 --power 5
    stepwright plan power --steps 2000 --accel 2000 --top-speed 1000 --power 3")]
pub struct Args {
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    begin: Begin,
    #[command(flatten)]
    power: Power,
    #[command(flatten)]
    common: Common,
}

/// How sharp the knee is.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Power {
    /// p of the power term, 2 to 9: the higher, the sharper the knee
    #[arg(long, value_name = "P", default_value_t = 4, allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u8).range(2..=9))]
    pub power: u8,
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
        let (p, part) = (self.power.power, self.begin.c0.part());
        let k = constant(&asked, asked.accels().0 * part, p.into());
        values.push(Value {
            name: "power term",
            shown: format!("k = {k:.4e}, p = {p}"),
            given: p.to_string(),
            held: k,
            unit: "",
        });
        let law = law(&asked, self.begin.c0, self.power)?;
        Plan::new("power", asked.rate, geometry, values, law)
    }
}

/// k by Eq 21; a top speed within the first step counts as one step away.
fn constant(asked: &Asked, accel: f64, p: i32) -> f64 {
    asked.motor().power(accel, asked.speed().max((2.0 * accel).sqrt()), p)
}

/// The law for these limits.
pub fn law(asked: &Asked, c0: First, Power { power }: Power) -> Result<Box<dyn Law>, Failure> {
    let delays = PowerTerm::new(asked.rate, asked.top.value, asked.accel.value, power)
        .with_decel(asked.decel.value)
        .with_c0(c0.core())
        .delays(asked.steps)?;

    let (motor, p) = (asked.motor(), i32::from(power));
    let (accel, decel) = asked.accels();
    let at = |accel| At { c: c0.counts(motor.c0(accel)).1, ..At::default() };
    let k = |accel| constant(asked, accel * c0.part(), p);
    let term = Term { p, up: k(accel), down: k(decel) };
    let least = motor.delay(asked.speed()).max(1.0);
    let up = |at: &mut At| term.faster(at);
    let down = |at: &mut At| Term { up: term.down, ..term }.faster(at);
    // No travel is long enough for all of the approach.
    let turns = shadow(asked.steps, least, at(accel), at(decel), up, down);
    let turns = Turns { complete: true, ..turns };
    let first = c0.counts(motor.c0(accel));
    let formula = Formula::new(Box::new(term), asked.steps, first, least, turns);
    let short = "the approach is asymptotic";
    Ok(Box::new(Counted::new(delays, formula, asked.rate, short)))
}

/// p and both k.
#[derive(Clone, Copy)]
struct Term {
    p: i32,
    up: f64,
    down: f64,
}

impl Ramps for Term {
    fn faster(&self, at: &mut At) {
        at.i += 1;
        at.c = next_power(at.c, at.i.into(), self.up, self.p);
    }

    fn slower(&self, c: f64, j: u32) -> f64 {
        let j = f64::from(j);
        c + 2.0 * c / (4.0 * j - 1.0 + self.down * j.powi(self.p))
    }
}
