//! Prints a plan as `stepwright plan trapezoid` does: what was understood, and what comes of it.

use stepwright::{Accel, Geometry, Rate, Speed};
use stepwright_plan::{LawChoice, PlanLimits, Survey, UNWATCHED, text};
use stepwright_units::Rounded;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let accel = Rounded::of(Accel::from_steps(4000)?, "/s²");
    let top = Rounded::of(Speed::from_steps(2000)?, "/s");
    let limits = PlanLimits { rate: Rate::MHZ, steps: 2000, decel: accel.clone(), accel, top };
    let law = LawChoice::Trapezoid { start: Rounded::of(Speed::ZERO, "/s") };
    let plan = law.plan(&limits, &Geometry::new(200)?, UNWATCHED)?;
    let survey = Survey::of(&plan, UNWATCHED);
    Ok(text::summary(&mut std::io::stdout().lock(), &plan, &survey, None)?)
}
