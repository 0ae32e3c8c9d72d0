//! Cycles from step to step where an axis is behind: the next step is due on
//! the way out of the one before, and is served in the same interrupt.

use anyhow::{Context, Result, ensure};

use super::Subject;
use super::job::{Axis, Job, median};
use super::table::Row;

/// Steps/s, faster than the chip can: the bench build refuses nothing. All
/// tops from 180,000 to 250,000 give the same figures.
const TOP: u32 = 250_000;
/// Steps/s² that keep the whole time on the ramp.
const ACCEL: u32 = 2_000_000;
/// Fewer pairs say nothing.
const ENOUGH: usize = 1_000;

pub(super) fn rows(subject: &Subject) -> Result<Vec<Row>> {
    let constant = between(subject, Axis::constant(TOP, 30_000))?;
    let ramp = between(subject, Axis { start: 0, top: TOP, accel: ACCEL, steps: 30_000 })?;
    let row = |name: &str, cycles: u64| Row::queued(name, 1, cycles as f64, "cycles");
    Ok(vec![row("back_to_back_constant", constant), row("back_to_back_ramp", ramp)])
}

/// The middle distance of two steps in one stay in the interrupt.
fn between(subject: &Subject, axis: Axis) -> Result<u64> {
    let (steps, visits) = Job::new(&[axis], false).begin(subject)?;
    let mut visits = visits.iter().peekable();
    let mut close = Vec::new();
    for pair in steps.windows(2) {
        while visits.next_if(|visit| visit.exit <= pair[0].time).is_some() {}
        if visits.peek().is_some_and(|visit| pair[1].time < visit.exit) {
            close.push(pair[1].time - pair[0].time);
        }
    }
    ensure!(close.len() >= ENOUGH, "only {} of {} steps were behind", close.len(), steps.len());
    median(&mut close).context("no steps")
}
