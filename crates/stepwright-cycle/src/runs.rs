//! The cost of planned runs on a board that plays them from its memory.
//!
//! Their steps take less time than those of a program that is asked for each step; but at the end
//! of a run the next one is looked up, between two steps of all motors.

use stepwright::drive::Drive;
use stepwright::timer::StepTimer;
use stepwright::units::Ticks;

use super::Cycle;
use super::player::ProgramRunner;
use super::program::RUNS;
use super::surroundings::MachineIo;

/// The time of steps of planned runs, in ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunCost {
    /// A step.
    pub cost: Ticks,
    /// The shortest interval of a motor.
    pub min_interval: Ticks,
    /// The shortest interval if several motors move and no step may be late
    /// ([`AtTiming::Cancel`](super::AtTiming::Cancel)): twice the time that a step may wait for the
    /// next run of another motor.
    pub on_time: Ticks,
}

impl<'a, T: StepTimer, D: Drive, S: MachineIo, const N: usize> Cycle<'a, T, D, S, N> {
    /// This cycle with a lower cost for steps of planned runs.
    pub const fn with_runs(mut self, runs: RunCost) -> Self {
        self.runs = Some(runs);
        self
    }

    /// On a board with a [`RunCost`], lets two steps come a quarter closer than they are planned:
    /// otherwise a late motor would get later with each step.
    pub(crate) fn set_pace(&mut self) {
        let Some(runs) = self.runs.filter(|_| RUNS && self.beat.is_free()) else { return };
        let mut timing = self.board.timing;
        let planned = |player: &mut ProgramRunner<'a>| {
            !player.is_ready() || player.is_paced() && !player.has_own_paces()
        };
        if self.engine.feeds().all(planned) {
            timing.min_interval = runs.min_interval;
        }
        timing.min_interval = timing.min_interval.saturating_sub(timing.min_interval >> 2);
        self.engine.set_timing(timing);
    }
}
