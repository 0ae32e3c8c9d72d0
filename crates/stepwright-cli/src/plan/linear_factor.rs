//! `plan linear-factor`: Austin's recommended transition.

use stepwright::{Geometry, Rate};
use stepwright_austin::LinearFactor;

use super::counted::Counted;
use super::formula::{At, Formula, Ramps, Turns};
use super::law::{Law, Plan, Value};
use super::limits::{Asked, Begin, First, Limits};
use super::{Common, Planned};
use crate::failure::Failure;
use crate::figures::law::{next_scaled, turning_point};

/// Acceleration that falls linearly to 0 at the top speed (Eq 22 to 25)
///
/// Up and down: a travel too short for the top speed goes from acceleration to
/// deceleration without a jump. The speed reached is an estimate of the
/// document, some tenths of a per cent below the top speed.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  Figure 8 of the article:
    stepwright plan linear-factor --steps 700 --accel 10rad/s2 --decel 20rad/s2 \\
      --top-speed 10rad/s --plot figure-8.png
  The factor beginning at half of the top speed:
    stepwright plan linear-factor --steps 1000 --accel 2000 --top-speed 1000 --knee 0.5")]
pub struct Args {
    #[command(flatten)]
    limits: Limits,
    #[command(flatten)]
    begin: Begin,
    #[command(flatten)]
    knee: Knee,
    #[command(flatten)]
    common: Common,
}

/// Where the linear factor begins.
#[derive(clap::Args, Clone, Copy, Debug)]
pub struct Knee {
    /// Where the linear factor begins, as a part of the top speed: 0 to 0.9
    #[arg(long, value_name = "PART", default_value = "0", value_parser = thousandths)]
    #[arg(allow_negative_numbers = true)]
    pub knee: u16,
}

/// A part in thousandths, of 0 to 0.9.
pub fn thousandths(text: &str) -> Result<u16, String> {
    let part: f64 = text.parse().map_err(|_| "give a part of the top speed, like 0.5")?;
    if (0.0..=0.9).contains(&part) {
        Ok((part * 1e3).round() as u16)
    } else {
        Err("it is 0 to 0.9".into())
    }
}

impl Planned for Args {
    fn common(&self) -> &Common {
        &self.common
    }

    fn plan(&self, rate: Rate, geometry: &Geometry) -> Result<Plan, Failure> {
        let asked = self.limits.held(rate, geometry)?;
        let core = core(&asked, self.begin.c0, self.knee);
        let corners = core.corners(asked.steps)?;
        let part = f64::from(self.knee.knee) / 1e3;
        let mut values = asked.values();
        let first = asked.motor().c0(asked.accels().0);
        values.push(self.begin.c0.value(self.begin.c0.counts(first).0));
        values.push(Value {
            name: "knee",
            shown: format!(
                "{part} of the top speed: n1 = {}, n2 = {}, n3 = {}",
                corners.n1,
                corners.n2,
                corners.n3(asked.steps)
            ),
            given: part.to_string(),
            held: part,
            unit: "of the top speed",
        });
        let law = law(&asked, self.begin.c0, self.knee)?;
        Plan::new("linear-factor", asked.rate, geometry, values, law)
    }
}

fn core(asked: &Asked, c0: First, Knee { knee }: Knee) -> LinearFactor {
    LinearFactor::new(asked.rate, asked.top.value, asked.accel.value)
        .with_decel(asked.decel.value)
        .with_c0(c0.core())
        .with_knee(knee)
}

/// The law for these limits.
pub fn law(asked: &Asked, c0: First, knee: Knee) -> Result<Box<dyn Law>, Failure> {
    let delays = core(asked, c0, knee).delays(asked.steps)?;
    let first = c0.counts(asked.motor().c0(asked.accels().0));
    let least = asked.motor().delay(asked.speed()).max(1.0);
    let (factor, turns) = corners(asked, c0, f64::from(knee.knee) / 1e3);
    let formula = Formula::new(Box::new(factor), asked.steps, first, least, turns);
    let short = "Eq 23 estimates it so";
    Ok(Box::new(Counted::new(delays, formula, asked.rate, short)))
}

/// n₁ and n₂ up, j₁ and j₂ down.
struct Factor {
    up: (f64, f64),
    down: (f64, f64),
}

fn corners(asked: &Asked, c0: First, knee: f64) -> (Factor, Turns) {
    let (motor, top, m) = (asked.motor(), asked.speed(), f64::from(asked.steps));
    let transition = |accel: f64| {
        let accel = accel * c0.part();
        let n1 = motor.step_of(knee * top, accel).round();
        match n1 > 0.0 {
            true => (n1, motor.transition(accel, n1, top).map_or(n1 + 1.0, f64::floor)),
            false => (0.0, motor.transition_from_rest(accel, top).max(1.0)),
        }
    };
    let (accel, decel) = asked.accels();
    let (mut up, mut down) = (transition(accel), transition(decel));
    let complete = up.1 + down.1 <= m || m < 2.0;
    if !complete {
        let short = turning_point(m, accel, decel).round().clamp(1.0, m - 1.0);
        let scaled = |(n1, n2): (f64, f64), n: f64| ((n1 * n / n2).round().min(n - 1.0), n);
        (up, down) = (scaled(up, short), scaled(down, m - short));
    }
    down.0 = down.0.max(1.0);
    // Where n₃ = n₂ that step is one of the way down.
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
