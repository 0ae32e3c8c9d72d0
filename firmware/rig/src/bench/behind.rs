//! Cycles from step to step in one stay in the interrupt: the time of the code if the next step is
//! due before the interrupt returns from the previous one. An interrupt that comes again as soon as
//! it has ended, after the one instruction that the chip executes in between, counts as the same
//! stay.
//!
//! The least distance is the figure, because nothing is faster than the code. Other distances are
//! longer by the wait of a step: for its deadline, or for the minimum interval of late steps.

use std::ops::RangeInclusive;

use anyhow::{Result, ensure};

use super::Subject;
use super::job::{Axis, Job, Traffic};
use super::table::Row;
use crate::probes::IsrSpan;

/// Steps/s near the limit of the chip: at some of them a byte on the line makes a step so late that
/// the next one is due before the interrupt returns. Which ones changes with every build.
const TOPS: RangeInclusive<u32> = 90_000..=200_000;
/// Steps/s between two tested speeds.
const APART: usize = 700;
/// Steps/s² at which the whole time is a ramp.
const ACCEL: u32 = 400_000;
/// Cycles of the longest instruction.
const INSTRUCTION: u64 = 4;
/// With fewer pairs the result is not significant.
const ENOUGH: usize = 50;

pub(super) fn rows(subject: &Subject) -> Result<Vec<Row>> {
    let constant = least(subject, |top| Axis::constant(top, top))?;
    let ramp = least(subject, |top| Axis { start: top / 4 * 3, top, accel: ACCEL, steps: top })?;
    let row = |name: &str, cycles: u64| Row::queued(name, 1, cycles as f64, "cycles");
    Ok(vec![row("back_to_back_constant", constant), row("back_to_back_ramp", ramp)])
}

/// The least distance of two steps in one stay in the interrupt.
fn least(subject: &Subject, axis: impl Fn(u32) -> Axis) -> Result<u64> {
    let mut close = Vec::new();
    for top in TOPS.step_by(APART) {
        let (steps, visits) = Job::new(&[axis(top)], Traffic::NOW).begin(subject)?;
        let mut stays: Vec<IsrSpan> = Vec::new();
        for visit in visits {
            match stays.last_mut() {
                Some(stay) if visit.entry <= stay.exit + INSTRUCTION => stay.exit = visit.exit,
                _ => stays.push(visit),
            }
        }
        let mut visits = stays.iter().peekable();
        for pair in steps.windows(2) {
            while visits.next_if(|visit| visit.exit <= pair[0].time).is_some() {}
            if visits.peek().is_some_and(|visit| pair[1].time < visit.exit) {
                close.push(pair[1].time - pair[0].time);
            }
        }
    }
    ensure!(close.len() >= ENOUGH, "only {} steps were due behind another", close.len());
    Ok(close.into_iter().min().unwrap_or(0))
}
