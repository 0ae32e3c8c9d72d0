//! The highest rates without a late step, in every phase of the traffic.
//!
//! Several axes get rates that differ by some tenths of a per cent, so that their steps meet in
//! every way; the lowest of them is the figure.
//!
//! A rate is kept if it is kept in all five phases. Most of the others fail in the same phase, so
//! the phase that failed last is tested first, and a run ends at its first late step: a kept rate
//! costs five runs, another one about a part of a run. If the stored figure only has to be
//! confirmed, no higher one is searched for.

use anyhow::Result;

use super::job::{Axis, Job, Traffic};
use super::table::Row;
use super::{Subject, Way};

/// Steps/s² of all ramps.
const ACCEL: u32 = 40_000;
/// Steps at the top speed, or in all without ramps,
const STEPS: u32 = 100_000;
/// but no more than this many seconds of them.
const SECONDS: u32 = 5;
/// Rates are tried on a grid of a quarter of a per cent.
const GRID: f64 = 1.0025;

pub(super) fn one(subject: &Subject) -> Result<Vec<Row>> {
    row(subject, "rate_ramps", 1)
}

pub(super) fn two(subject: &Subject) -> Result<Vec<Row>> {
    row(subject, "rate_ramps", 2)
}

pub(super) fn three(subject: &Subject) -> Result<Vec<Row>> {
    row(subject, "rate_ramps", 3)
}

pub(super) fn constant_one(subject: &Subject) -> Result<Vec<Row>> {
    row(subject, "rate_constant", 1)
}

pub(super) fn constant_three(subject: &Subject) -> Result<Vec<Row>> {
    row(subject, "rate_constant", 3)
}

fn row(subject: &Subject, name: &str, axes: u8) -> Result<Vec<Row>> {
    let rate = highest(subject, name, axes)?;
    Ok(vec![Row::queued(name, axes, rate.into(), "steps/s")])
}

/// Rates that differ a little, the lowest first.
fn spread(axes: u8, rate: u32) -> impl Iterator<Item = u32> {
    (0..u32::from(axes)).map(move |n| rate + rate * 3 * n / 1000)
}

/// Steps at the top speed: the same number for all axes, so that one continues while another ends.
fn level(rate: u32) -> u32 {
    STEPS.min(rate.saturating_mul(SECONDS))
}

fn ramps(axes: u8, rate: u32) -> Vec<Axis> {
    let axis = |top: u32| {
        let both = (u64::from(top) * u64::from(top) / u64::from(ACCEL)) as u32;
        Axis::ramps(top, ACCEL, both + level(rate))
    };
    spread(axes, rate).map(axis).collect()
}

fn constants(axes: u8, rate: u32) -> Vec<Axis> {
    spread(axes, rate).map(|speed| Axis::constant(speed, level(rate))).collect()
}

/// Why a travel is not kept in one phase; `None` if it is.
pub(super) fn fault(subject: &Subject, axes: &[Axis], traffic: Traffic) -> Result<Option<String>> {
    let outcome = match Job::new(axes, traffic).on_time().run(subject, |_| {})? {
        Ok(outcome) => outcome,
        Err(fault) => return Ok(Some(fault)),
    };
    let made =
        axes.iter().zip(&outcome.steps).find(|(axis, made)| made.len() != axis.steps as usize);
    Ok(if let Some((axis, made)) = made {
        Some(format!("{} steps of {}", made.len(), axis.steps))
    } else if outcome.chip.lost() != 0 {
        Some(format!("{} bytes lost", outcome.chip.lost()))
    } else if outcome.late != 0 {
        Some(format!("the board counts {} late steps", outcome.late))
    } else {
        None
    })
}

/// The highest rate on the grid that is kept while the next one is not; 0 if even 1000 steps/s is
/// not. If figures are only compared, a stored rate that is kept is returned.
fn highest(subject: &Subject, name: &str, axes: u8) -> Result<u32> {
    let rate = |k: i32| (1000.0 * GRID.powi(k)).round() as u32;
    // The phase that failed last comes first.
    let mut phases = [0, 1, 2, 3, 4];
    let mut kept = |k: i32| {
        let axes = match name {
            "rate_constant" => constants(axes, rate(k)),
            _ => ramps(axes, rate(k)),
        };
        for place in 0..phases.len() {
            let phase = phases[place];
            if let Some(fault) = fault(subject, &axes, Traffic::NOW.in_phase(phase))? {
                let (count, rate) = (axes.len(), rate(k));
                eprintln!(
                    "{} {name} of {count}: {rate} fails in phase {phase}: {fault}",
                    Way::Queued.name()
                );
                phases[..=place].rotate_right(1);
                return anyhow::Ok(false);
            }
        }
        eprintln!("{} {name} of {}: {} is kept", Way::Queued.name(), axes.len(), rate(k));
        Ok(true)
    };
    let stored = subject.known.get(name, axes, Way::Queued.name());
    if subject.compare && stored == Some(0.0) {
        // The stored figure is 0: there is nothing to confirm.
        return Ok(0);
    }
    let hint = stored.unwrap_or(20_000.0);
    let hint = ((hint.max(1001.0) / 1000.0).ln() / GRID.ln()).round() as i32;
    // Strides that double, away from the hint, until the result changes; then bisection.
    let (mut low, mut high, mut stride) = (hint, hint + 1, 1);
    if kept(hint)? {
        if subject.compare {
            return Ok(rate(hint));
        }
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
