//! Cycles of a step, of a reload, of planning, and with interrupts off; sizes.

use anyhow::{Context, Error, Result, ensure};

use super::job::{Axis, Job, Traffic, median};
use super::table::Row;
use super::{Subject, Way};
use crate::board::HZ;
use crate::chip::Chip;
use crate::probes::IsrSpan;

/// One axis so slow that each step has an interrupt of its own.
pub(super) fn isolated(subject: &Subject) -> Result<Vec<Row>> {
    let constant = visits(subject, Axis::constant(2_000, 6_000))?;
    // The ramps fill the whole travel.
    let ramp = visits(subject, Axis::ramps(4_000, 2_600, 6_000))?;
    let cycles = |visits: &[IsrSpan]| -> Vec<u64> {
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

fn visits(subject: &Subject, axis: Axis) -> Result<Vec<IsrSpan>> {
    let outcome = Job::new(&[axis], Traffic::Silent).keeping_visits().run(subject, |_| {})?;
    let mut outcome = outcome.map_err(Error::msg)?;
    let last = outcome.steps[0].last().context("no steps")?.time;
    let mut visits = outcome.chip.take_visits();
    // After the last step there is no step in a visit.
    visits.retain(|visit| visit.entry < last);
    visits.pop();
    Ok(visits)
}

/// The motors of the cycle's example, and the observed time: its third motor steps every 20 ms.
const MOTORS: usize = 3;
const WATCHED: u64 = 3 * HZ;

/// Steps of a motor cycle, of one, two and three motors at once, while three move: the median stay
/// in the step interrupt.
pub(super) fn motor_cycle(subject: &Subject) -> Result<Vec<Row>> {
    let mut chip = Chip::new(subject.board, &subject.cycle.bench);
    chip.keep_visits();
    chip.run_for(WATCHED);
    let steps: Vec<u64> =
        chip.edges().iter().filter(|edge| edge.is_step()).map(|edge| edge.time).collect();
    let mut stays = [const { Vec::new() }; MOTORS];
    for visit in chip.take_visits() {
        let made = steps.partition_point(|at| *at < visit.exit)
            - steps.partition_point(|at| *at < visit.entry);
        if let Some(stays) = made.checked_sub(1).and_then(|place| stays.get_mut(place)) {
            stays.push(visit.exit - visit.entry);
        }
    }
    let row = |(motors, stays): (u8, &mut Vec<u64>)| {
        let stay = median(stays).with_context(|| format!("no {motors} steps at once"))?;
        Ok(Row::of(Way::Cycle, "cycle_step", motors, stay as f64, "cycles"))
    };
    (1..).zip(&mut stays).map(row).collect()
}

/// Three axes, at rates that they keep.
fn axes() -> [Axis; 3] {
    [
        Axis::ramps(10_000, 20_000, 20_000),
        Axis::ramps(9_500, 18_500, 19_000),
        Axis::ramps(8_500, 15_500, 17_500),
    ]
}

/// Ramps of three axes, under traffic.
pub(super) fn three_axes(subject: &Subject) -> Result<Vec<Row>> {
    let job = Job::new(&axes(), Traffic::NOW);
    let order = order_burst(subject, &job)?;
    let planner = function(subject, "4plan")?;
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
        Row::queued("order_burst", 3, order as f64, "cycles"),
        Row::queued("interrupts_off", 3, off as f64, "cycles"),
        Row::queued("stack", 3, stack.into(), "bytes"),
    ])
}

/// The address of a part of the main loop.
fn function(subject: &Subject, name: &str) -> Result<u32> {
    let parts = ["9main_loop", name];
    let found = subject.queued.bench.functions(&parts).next();
    Ok(found
        .with_context(|| format!("the bench build has no part {name} of the main loop"))?
        .address)
}

/// Starting an order: the longest call among those that receive its `E`, and those that each do one
/// piece of the start up to the answer.
fn order_burst(subject: &Subject, job: &Job) -> Result<u64> {
    let mut longest = 0;
    for method in ["6listen", "4work"] {
        let mut chip = job.told(subject)?;
        chip.watch_calls(function(subject, method)?);
        ensure!(chip.ask("E").as_deref() == Some("Y"), "the order is refused");
        longest = longest.max(chip.take_calls().into_iter().max().context("nobody listens")?);
    }
    Ok(longest)
}

/// The bytes of the ordinary build.
pub(super) fn sizes(subject: &Subject) -> Result<Vec<Row>> {
    let plain = &subject.queued.plain;
    let sizes = [("flash", plain.flash.len() as f64), ("ram", plain.ram.into())];
    Ok(sizes.map(|(name, bytes)| Row::queued(name, 3, bytes, "bytes")).into())
}
