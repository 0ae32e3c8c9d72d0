//! Cycles: of a step, of a reload, of planning, with interrupts off; sizes.

use anyhow::{Context, Error, Result};

use super::Subject;
use super::job::{Axis, Job, median};
use super::table::Row;
use crate::taps::Visit;

/// One axis so slow that each step has an interrupt of its own.
pub(super) fn isolated(subject: &Subject) -> Result<Vec<Row>> {
    let constant = visits(subject, Axis::constant(2_000, 6_000))?;
    // The ramps fill the whole travel.
    let ramp = visits(subject, Axis::ramps(4_000, 2_600, 6_000))?;
    let cycles = |visits: &[Visit]| -> Vec<u64> {
        // Without the beginning, which waits for hold and set-up.
        visits.iter().skip(100).map(|visit| visit.exit - visit.entry).collect()
    };
    let (mut constant, mut ramp) = (cycles(&constant), cycles(&ramp));
    let longest = constant.iter().chain(&ramp).max().copied().context("no steps")?;
    let row = |name: &str, value: u64| Row::queued(name, 1, value as f64, "cycles");
    Ok(vec![
        row("isolated", median(&mut constant).context("no steps")?),
        row("isolated_ramp", median(&mut ramp).context("no steps")?),
        row("reload", longest),
    ])
}

fn visits(subject: &Subject, axis: Axis) -> Result<Vec<Visit>> {
    let outcome = Job::new(&[axis], false).keeping_visits().run(subject, |_| {})?;
    let mut outcome = outcome.map_err(Error::msg)?;
    let last = outcome.steps[0].last().context("no steps")?.time;
    let mut visits = outcome.chip.take_visits();
    // What follows the last step is no step.
    visits.retain(|visit| visit.entry < last);
    visits.pop();
    Ok(visits)
}

/// Three axes at some of their highest rate, under traffic.
pub(super) fn three_axes(subject: &Subject) -> Result<Vec<Row>> {
    let axes = [
        Axis::ramps(20_000, 40_000, 40_000),
        Axis::ramps(19_000, 37_000, 38_000),
        Axis::ramps(17_000, 31_000, 35_000),
    ];
    let job = Job::new(&axes, true);
    let planner = subject
        .bench
        .functions(&["5Slave", "4plan"])
        .next()
        .context("the bench build has no function Slave::plan")?
        .address;
    let outcome = job.run(subject, |chip| {
        chip.clear_longest_off();
        chip.watch_calls(planner);
    })?;
    let mut chip = outcome.map_err(Error::msg)?.chip;
    let longest = chip.take_calls().into_iter().max().context("nothing was planned")?;
    let off = chip.longest_off().0;
    let stack = chip.ram().1;
    Ok(vec![
        Row::queued("planning_burst", 3, longest as f64, "cycles"),
        Row::queued("interrupts_off", 3, off as f64, "cycles"),
        Row::queued("stack", 3, stack.into(), "bytes"),
    ])
}

/// Bytes of the ordinary build.
pub(super) fn sizes(subject: &Subject) -> Result<Vec<Row>> {
    let flash = subject.plain.flash.len() as f64;
    Ok(vec![
        Row::queued("flash", 3, flash, "bytes"),
        Row::queued("ram", 3, subject.plain.ram.into(), "bytes"),
    ])
}
