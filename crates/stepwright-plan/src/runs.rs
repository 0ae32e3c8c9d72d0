//! What a board gets: the travel as runs, and how far they are off.

use stepwright::Run;

use crate::law::{Closeness, Plan};
use crate::survey::{Player, Worst};

/// A run in the list.
#[derive(Clone, Copy, Debug)]
pub struct RunLine {
    /// Counted from 1.
    pub number: u32,
    /// The step that it begins with, counted from 1: the first pulse is not
    /// part of any run.
    pub step: u32,
    /// First interval, in ticks.
    pub interval: f64,
    /// Its growth per step, in ticks.
    pub add: f64,
    /// Steps.
    pub count: u16,
    /// From the first pulse to the run's last step, in ticks.
    pub end: f64,
}

/// 2⁻¹⁶ ticks in ticks; exact for an interval, which has 48 bits.
fn ticks(fine: u64) -> f64 {
    fine as f64 / 65_536.0
}

/// The runs of a plan, one by one.
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

/// All runs together.
#[derive(Clone, Copy, Debug)]
pub struct RunTotal {
    /// How many.
    pub runs: u64,
    /// What they take in memory.
    pub bytes: u64,
    /// Largest distance of a step, as a board emits it, from its ideal.
    pub worst: Worst,
}

/// Plays the runs as the engine does, and measures the steps.
pub fn total(plan: &Plan, fit: Closeness) -> RunTotal {
    let mut player = Player::new(plan.law.as_ref());
    let runs = plan.law.runs(fit).map(|run| player.run(run)).count() as u64;
    RunTotal { runs, bytes: runs * size_of::<Run>() as u64, worst: player.worst }
}
