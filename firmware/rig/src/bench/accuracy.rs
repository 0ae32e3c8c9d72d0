//! The distance of the edges from the ideal.
//!
//! The travels and the definitions are those used to measure the peers: an ideal trapezoid at rest
//! at the first and the last pulse.

use anyhow::{Context, Error, Result};
use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

use super::Subject;
use super::job::{Axis, Job, Traffic, median, offsets};
use super::table::Row;
use crate::board::HZ;

/// 4,000 steps, 10,000 steps/s², 4,000 steps/s.
const M1: Axis = Axis { start: 0, top: 4_000, accel: 10_000, steps: 4_000 };
/// 20,000 steps, 40,000 steps/s², 20,000 steps/s.
const M2: Axis = Axis { start: 0, top: 20_000, accel: 40_000, steps: 20_000 };

/// One axis, without traffic.
pub(super) fn alone(subject: &Subject) -> Result<Vec<Row>> {
    let row = |name: &str, value: f64, unit: &str| Row::queued(name, 1, value, unit);
    Ok(vec![
        row("interval_rms", interval_rms(&times(subject, M1)?), "%"),
        row("accel_peak", accel_peak(&times(subject, M2)?), "times"),
        row("accel_peak_deadlines", accel_peak(&deadlines(M2)), "times"),
    ])
}

/// Edge errors under traffic, for one axis and for three.
pub(super) fn with_traffic(subject: &Subject) -> Result<Vec<Row>> {
    let mut rows = errors(subject, &[M2])?;
    let two = [M2, Axis { top: 13_000, ..M2 }];
    rows.extend(errors(subject, &two)?);
    let three = [M2, Axis { top: 13_000, ..M2 }, Axis { top: 7_000, ..M2 }];
    rows.extend(errors(subject, &three)?);
    Ok(rows)
}

fn times(subject: &Subject, axis: Axis) -> Result<Vec<u64>> {
    let outcome = Job::new(&[axis], Traffic::Silent).run(subject, |_| {})?.map_err(Error::msg)?;
    Ok(outcome.steps[0].iter().map(|step| step.time).collect())
}

/// The step times of the same planner on the virtual board, which has no latency.
fn deadlines(axis: Axis) -> Vec<u64> {
    let mut queues = Queues::default();
    let mut board: VirtualBoard<u16, Vec<Edge>> =
        VirtualBoard::new(&mut queues, Description::uno(), Vec::new());
    let Axis { start, top, accel, steps, .. } = axis;
    let order = format!("PO\rs{start}\rt{top}\ra{accel}\rd{accel}\rG+{steps}\rE\r");
    order.bytes().for_each(|byte| board.receive(byte));
    board.run_to_rest();
    board.recorder().iter().filter(|edge| edge.is_step()).map(|edge| edge.time).collect()
}

/// The ideal time of pulse n, in cycles after the first. The travel must reach its top speed.
fn ideal(axis: &Axis, n: usize) -> f64 {
    let (accel, top) = (f64::from(axis.accel), f64::from(axis.top));
    let (n, last) = (n as f64, f64::from(axis.steps - 1));
    let ramp = top * top / (2.0 * accel);
    let rise = |n: f64| (2.0 * n / accel).sqrt();
    let seconds = if n < ramp {
        rise(n)
    } else if n < last - ramp {
        rise(ramp) + (n - ramp) / top
    } else {
        2.0 * top / accel + (last - 2.0 * ramp) / top - rise(last - n)
    };
    seconds * HZ as f64
}

/// The root mean square deviation of M1's intervals from the ideal, in per cent, without the first
/// and the last two.
fn interval_rms(times: &[u64]) -> f64 {
    let last = times.len() - 1;
    let squares: Vec<f64> = (2..last - 2)
        .map(|n| {
            let want = ideal(&M1, n + 1) - ideal(&M1, n);
            ((times[n + 1] - times[n]) as f64 / want - 1.0).powi(2)
        })
        .collect();
    100.0 * (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// The largest acceleration between neighbouring means of 8 steps of M2, relative to the nominal
/// one.
fn accel_peak(times: &[u64]) -> f64 {
    let span = |k: usize| (times[8 * k + 8] - times[8 * k]) as f64;
    let speed = |k: usize| 8.0 * HZ as f64 / span(k);
    let accel = |k: usize| {
        let time = (span(k) + span(k + 1)) / 2.0 / HZ as f64;
        (speed(k + 1) - speed(k)).abs() / time / f64::from(M2.accel)
    };
    (1..times.len() / 8 - 2).map(accel).fold(0.0, f64::max)
}

/// The distances of the edges from the closed form, relative to the median distance, which is the
/// constant part.
fn errors(subject: &Subject, axes: &[Axis]) -> Result<Vec<Row>> {
    let outcome = Job::new(axes, Traffic::NOW).run(subject, |_| {})?.map_err(Error::msg)?;
    let mut errors = Vec::new();
    for (axis, steps) in axes.iter().zip(&outcome.steps) {
        let mut offsets = offsets(steps, &axis.ideal()?);
        let middle = median(&mut offsets).context("no steps")?;
        errors.extend(offsets.iter().map(|offset| offset.abs_diff(middle)));
    }
    errors.sort_unstable();
    let at = |share: f64| errors[((errors.len() - 1) as f64 * share) as usize] as f64;
    let row = |name: &str, share| Row::queued(name, axes.len() as u8, at(share), "cycles");
    Ok(vec![
        row("edge_error_median", 0.5),
        row("edge_error_99", 0.99),
        row("edge_error_worst", 1.0),
    ])
}
