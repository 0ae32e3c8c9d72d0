//! The travel as runs for a board, and their largest error.

use stepwright::Run;

use crate::law::{Closeness, Plan};
use crate::survey::{Player, Worst};

/// A run in the list.
#[derive(Clone, Copy, Debug)]
pub struct RunLine {
    /// Counted from 1.
    pub number: u32,
    /// Its first step, counted from 1. The first pulse is part of no run.
    pub step: u32,
    /// First interval, in ticks.
    pub interval: f64,
    /// Its growth per step, in ticks.
    pub add: f64,
    /// The number of steps.
    pub count: u16,
    /// Time from the first pulse to the last step of the run, in ticks.
    pub end: f64,
}

/// Converts 2⁻¹⁶ ticks to ticks. Exact for an interval, which has 48 bits.
fn ticks(fine: u64) -> f64 {
    fine as f64 / 65_536.0
}

/// The runs of a plan, one at a time.
pub fn lines(plan: &Plan, fit: Closeness) -> impl Iterator<Item = RunLine> + '_ {
    let (mut step, mut end) = (2u32, 0u64);
    plan.law.runs(fit).zip(1..).map(move |(run, number)| {
        end += run.duration();
        let line = RunLine {
            number,
            step,
            interval: ticks(run.interval()),
            add: f64::from(run.add()) / 65_536.0,
            count: run.count(),
            end: ticks(end),
        };
        step += u32::from(run.count());
        line
    })
}

/// The sum of all runs.
#[derive(Clone, Copy, Debug)]
pub struct RunTotal {
    /// The number of runs.
    pub runs: u64,
    /// Their size in memory in bytes.
    pub bytes: u64,
    /// The step furthest from its ideal, as a board emits it.
    pub worst: Worst,
}

/// Plays the runs as the engine does and measures the steps.
pub fn total(plan: &Plan, fit: Closeness) -> RunTotal {
    let mut player = Player::new(plan.law.as_ref());
    let runs = plan.law.runs(fit).map(|run| player.run(run)).count() as u64;
    RunTotal { runs, bytes: runs * size_of::<Run>() as u64, worst: player.worst }
}
