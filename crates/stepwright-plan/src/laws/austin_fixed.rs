//! Austin's published listing.

use stepwright::{Geometry, Rate};
use stepwright_austin::Fixed;

use super::austin::Plain;
use super::counted::Counted;
use super::formula::{At, Formula, Ramps, Turns};
use crate::PlanError;
use crate::law::{Plan, PlanValue};
use crate::watch::Watch;

impl Plan {
    /// Austin's ramp as published, in fixed point, equal in every delay. The first delay sets the
    /// acceleration, the shortest delay the top speed; both are in ticks, 1 to 2³¹ − 1.
    ///
    /// # Errors
    /// [`PlanError::TooFast`]
    pub fn austin_fixed(
        rate: Rate,
        geometry: &Geometry,
        steps: u32,
        (first, shortest): (u32, u32),
        watch: Watch<'_>,
    ) -> Result<Plan, PlanError> {
        let least = f64::from(shortest);
        let c0 = f64::from(first.max(shortest));
        let turns = turns(steps, c0, least);
        let ramps = Box::new(Plain { two: false });
        let formula = Formula::new(ramps, steps, (c0, c0), least, turns, watch);
        let law = Counted::new(Fixed::new(steps, first, shortest), formula, rate, "");

        // Eq 15 and 2, in steps.
        let hz = f64::from(rate.hz());
        let accel = 2.0 * (0.676 * hz / c0).powi(2);
        let values = vec![
            ticks("first delay", first, format!("about {accel:.1} steps/s²")),
            ticks("shortest delay", shortest, format!("{:.3} steps/s", hz / least)),
        ];
        let mut plan = Plan::new("austin-fixed", rate, geometry, values, Box::new(law))?;
        plan.note = (first <= shortest).then(|| {
            format!("the first delay is not above the shortest: no ramp, all at {shortest} ticks")
        });
        Ok(plan)
    }
}

fn ticks(name: &'static str, held: u32, means: String) -> PlanValue {
    let shown = format!("{held} ticks → {means}");
    PlanValue { name, shown, given: held.to_string(), held: held.into(), unit: "ticks" }
}

/// As many steps down as up; from the shortest delay three fewer, as published.
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
