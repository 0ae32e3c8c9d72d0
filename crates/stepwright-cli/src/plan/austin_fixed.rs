//! `plan austin-fixed`: Austin's published listing.

use stepwright::{Geometry, Rate};
use stepwright_austin::Fixed;

use super::austin::Plain;
use super::counted::Counted;
use super::formula::{At, Formula, Ramps, Turns};
use super::law::{Plan, Value};
use super::{Common, Planned, Steps};
use crate::failure::Failure;

/// Austin's ramp as it was published: fixed point, 24.8, delay for delay
///
/// The first delay sets the acceleration, the shortest the top speed; the
/// deceleration is the same. The error that the summary shows is that of the
/// listing's truncating divisions against Eq 12.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  The demo of the article, five turns of a 1.8° motor:
    stepwright plan austin-fixed --steps 1000 --c0 50000 --c-min 2500
  Its delays:
    stepwright plan austin-fixed --steps 10 --c0 50000 --c-min 2500 --format csv")]
pub struct Args {
    #[command(flatten)]
    steps: Steps,
    /// The first delay, in ticks, 1 to 2147483647
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=0x7FFF_FFFF))]
    c0: u32,
    /// The shortest delay, in ticks, 1 to 2147483647
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=0x7FFF_FFFF))]
    c_min: u32,
    #[command(flatten)]
    common: Common,
}

impl Planned for Args {
    fn common(&self) -> &Common {
        &self.common
    }

    fn plan(&self, rate: Rate, geometry: &Geometry) -> Result<Plan, Failure> {
        let (steps, least) = (self.steps.held(geometry)?, f64::from(self.c_min));
        let c0 = f64::from(self.c0.max(self.c_min));
        let turns = turns(steps, c0, least);
        let formula = Formula::new(Box::new(Plain { two: false }), steps, (c0, c0), least, turns);
        let law = Counted::new(Fixed::new(steps, self.c0, self.c_min), formula, rate, "");

        // Eq 15 and 2, in steps.
        let hz = f64::from(rate.hz());
        let accel = 2.0 * (0.676 * hz / c0).powi(2);
        let mut plan = Plan::new(
            "austin-fixed",
            rate,
            geometry,
            vec![
                ticks("first delay", self.c0, format!("about {accel:.1} steps/s²")),
                ticks("shortest delay", self.c_min, format!("{:.3} steps/s", hz / least)),
            ],
            Box::new(law),
        )?;
        plan.note = (self.c0 <= self.c_min).then(|| {
            format!(
                "the first delay is not above the shortest: no ramp, all at {} ticks",
                self.c_min
            )
        });
        Ok(plan)
    }
}

fn ticks(name: &'static str, held: u32, means: String) -> Value {
    let shown = format!("{held} ticks → {means}");
    Value { name, shown, given: held.to_string(), held: held.into(), unit: "ticks" }
}

/// As many steps down as up; three fewer from the shortest delay, as published.
fn turns(pulses: u32, c: f64, least: f64) -> Turns {
    let middle = pulses.saturating_sub(1) / 2;
    let mut at = At { c, ..At::default() };
    while at.c.round() > least && at.i < middle {
        Plain { two: false }.faster(&mut at);
    }
    let complete = at.c.round() <= least;
    let down = if complete { at.i.saturating_sub(3) } else { at.i };
    Turns { up: at.i, down, complete }
}
