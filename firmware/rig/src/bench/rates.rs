//! The highest rates without a late step.
//!
//! Several axes get rates that differ by some tenths of a per cent, so that
//! their steps fall together in every way; the lowest of them is the figure.

use std::result;

use anyhow::{Error, Result};

use super::job::{Axis, Job, Outcome, offsets};
use super::table::Row;
use super::{Subject, Way};

/// Steps/s² of all ramps.
const ACCEL: u32 = 40_000;
/// Steps at the top speed, or in all without ramps.
const STEPS: u32 = 100_000;
/// Rates are tried on a grid of a quarter of a per cent.
const GRID: f64 = 1.0025;
/// Runs keep to the law within 1 µs on either side.
const FIT: i64 = 32;

pub(super) fn one(subject: &Subject) -> Result<Vec<Row>> {
    let rate = highest(subject, Way::Queued, "rate_ramps", 1)?;
    Ok(vec![Row::queued("rate_ramps", 1, rate.into(), "steps/s")])
}

pub(super) fn two(subject: &Subject) -> Result<Vec<Row>> {
    let rate = highest(subject, Way::Queued, "rate_ramps", 2)?;
    Ok(vec![Row::queued("rate_ramps", 2, rate.into(), "steps/s")])
}

pub(super) fn three(subject: &Subject) -> Result<Vec<Row>> {
    let rate = highest(subject, Way::Queued, "rate_ramps", 3)?;
    let mut rows = vec![Row::queued("rate_ramps", 3, rate.into(), "steps/s")];
    if rate > 0 {
        let outcome = play(subject, Way::Queued, &ramps(3, rate))?.map_err(Error::msg)?;
        rows.push(Row::queued("late_steps", 3, outcome.late.into(), "steps"));
    }
    Ok(rows)
}

pub(super) fn constant(subject: &Subject) -> Result<Vec<Row>> {
    let three = highest(subject, Way::Queued, "rate_constant", 3)?;
    let one = highest(subject, Way::Queued, "rate_constant", 1)?;
    Ok(vec![
        Row::queued("rate_constant", 3, three.into(), "steps/s"),
        Row::queued("rate_constant", 1, one.into(), "steps/s"),
    ])
}

pub(super) fn direct(subject: &Subject) -> Result<Vec<Row>> {
    let rate = |axes| -> Result<Row> {
        let rate = highest(subject, Way::Direct, "rate_ramps", axes)?;
        Ok(Row::of(Way::Direct, "rate_ramps", axes, rate.into(), "steps/s"))
    };
    (1..=3).map(rate).collect()
}

/// Rates that differ a little, the lowest first.
fn spread(axes: u8, rate: u32) -> impl Iterator<Item = u32> {
    (0..u32::from(axes)).map(move |n| rate + rate * 3 * n / 1000)
}

fn ramps(axes: u8, rate: u32) -> Vec<Axis> {
    let axis = |top: u32| {
        let both = (u64::from(top) * u64::from(top) / u64::from(ACCEL)) as u32;
        Axis::ramps(top, ACCEL, both + STEPS)
    };
    spread(axes, rate).map(axis).collect()
}

fn constants(axes: u8, rate: u32) -> Vec<Axis> {
    spread(axes, rate).map(|speed| Axis::constant(speed, STEPS)).collect()
}

fn play(subject: &Subject, way: Way, axes: &[Axis]) -> Result<result::Result<Outcome, String>> {
    Job::new(axes, true).by(way).run(subject, |_| {})
}

/// Why some step does not come within half its interval of its time; `None` if
/// all do.
fn fault(subject: &Subject, way: Way, axes: &[Axis]) -> Result<Option<String>> {
    let outcome = match play(subject, way, axes)? {
        Ok(outcome) => outcome,
        Err(fault) => return Ok(Some(fault)),
    };
    if outcome.chip.lost() != 0 {
        return Ok(Some(format!("{} bytes lost", outcome.chip.lost())));
    }
    // The step that is latest by its interval: how far over its half, and which.
    let (mut over, mut latest) = (i64::MIN, String::new());
    for ((number, axis), steps) in (1..).zip(axes).zip(&outcome.steps) {
        let path = axis.ideal(way)?;
        if steps.len() != axis.steps as usize {
            return Ok(Some(format!("{} steps of {}", steps.len(), axis.steps)));
        }
        let offsets = offsets(steps, &path);
        // The first step's latency is in all of them: the least is none.
        let least = offsets.iter().copied().min().unwrap_or(0);
        for (n, offset) in offsets.iter().enumerate().skip(1) {
            let interval = path.time_of(n as u32) - path.time_of(n as u32 - 1);
            let late = offset - least;
            if late - interval as i64 / 2 > over {
                over = late - interval as i64 / 2;
                latest = format!("step {n} of axis {number} is {late} of {interval} cycles late");
            }
        }
    }
    let kept = outcome.late == 0 && over <= FIT;
    Ok((!kept).then(|| format!("{} late steps, {latest}", outcome.late)))
}

/// The highest rate on the grid that is kept while the next one is not; 0 if
/// not even 1000 steps/s are.
fn highest(subject: &Subject, way: Way, name: &str, axes: u8) -> Result<u32> {
    let rate = |k: i32| (1000.0 * GRID.powi(k)).round() as u32;
    let kept = |k: i32| {
        let axes = match name {
            "rate_constant" => constants(axes, rate(k)),
            _ => ramps(axes, rate(k)),
        };
        let fault = fault(subject, way, &axes)?;
        let verdict = fault.as_deref().unwrap_or("kept");
        eprintln!("{}: {name} of {} at {} steps/s: {verdict}", way.name(), axes.len(), rate(k));
        anyhow::Ok(fault.is_none())
    };
    let hint = subject.known.get(name, axes, way.name()).unwrap_or(20_000.0);
    let hint = ((hint.max(1001.0) / 1000.0).ln() / GRID.ln()).round() as i32;
    // Strides that double, away from the hint, until it changes; then halves.
    let (mut low, mut high, mut stride) = (hint, hint + 1, 1);
    if kept(hint)? {
        while kept(high)? {
            (low, stride) = (high, 2 * stride);
            high += stride;
        }
    } else {
        (low, high) = (hint - 1, hint);
        while !kept(low)? {
            (high, stride) = (low, 2 * stride);
            low -= stride;
            if low < 0 {
                return Ok(0);
            }
        }
    }
    while high - low > 1 {
        let middle = (low + high) / 2;
        if kept(middle)? { low = middle } else { high = middle }
    }
    Ok(rate(low))
}
