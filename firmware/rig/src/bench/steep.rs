//! The steepest ramps without a late step: they show how much can be planned while axes move.
//!
//! All axes are alike, so that their runs and corners coincide, while the host requests the longest
//! answer without a pause.

use anyhow::Result;

use super::Subject;
use super::job::{Axis, Traffic};
use super::rates::fault;
use super::table::Row;

/// Steps/s: fast enough for ramps of many runs.
const TOP: u32 = 10_000;
/// Steps/s² are tested from here downward, in steps of a twentieth,
const HIGHEST: f64 = 1_500_000.0;
const GRID: f64 = 1.05;
/// until this many in a row are kept, each in this many phases of the traffic.
const ENOUGH: usize = 4;
const PHASES: usize = 3;

pub(super) fn rows(subject: &Subject) -> Result<Vec<Row>> {
    let row = |axes| {
        let steepest = steepest(subject, axes)?;
        Ok(Row::queued("steepest", axes, steepest.into(), "steps/s²"))
    };
    (1..=3).map(row).collect()
}

/// The highest acceleration that is kept, together with those just below it.
fn steepest(subject: &Subject, axes: u8) -> Result<u32> {
    let mut kept = Vec::new();
    for k in 0.. {
        let accel = (HIGHEST / GRID.powi(k)).round() as u32;
        // Both ramps, and some steps between them.
        let steps = TOP * (TOP / accel + 1) + TOP / 4;
        if is_kept(subject, &vec![Axis::ramps(TOP, accel, steps); axes.into()])? {
            kept.push(accel);
        } else {
            kept.clear();
        }
        if kept.len() == ENOUGH {
            break;
        }
    }
    Ok(kept[0])
}

fn is_kept(subject: &Subject, axes: &[Axis]) -> Result<bool> {
    for phase in 0..PHASES {
        if fault(subject, axes, Traffic::Asks(&["?"], 0).in_phase(phase))?.is_some() {
            return Ok(false);
        }
    }
    Ok(true)
}
