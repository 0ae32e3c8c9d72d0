//! What planned runs cost a board that plays them from its memory.
//!
//! Their steps take less time than those of a program that is asked for each; but where a run
//! ends the next one is looked up, between two steps of all motors.

use stepwright::drive::Drive;
use stepwright::timer::StepTimer;
use stepwright::units::Ticks;

use super::Cycle;
use super::player::ProgramRunner;
use super::program::RUNS;
use super::surroundings::MachineIo;

/// What steps of planned runs take, in ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunCost {
    /// A step.
    pub cost: Ticks,
    /// From step to step of a motor, at least.
    pub min_interval: Ticks,
    /// Likewise where several motors move and no step may be late
    /// ([`AtTiming::Cancel`](super::AtTiming::Cancel)): twice what a step may wait for another
    /// motor's next run.
    pub on_time: Ticks,
}

impl<'a, T: StepTimer, D: Drive, S: MachineIo, const N: usize> Cycle<'a, T, D, S, N> {
    /// The same where steps of planned runs take less than others.
    pub const fn with_runs(mut self, runs: RunCost) -> Self {
        self.runs = Some(runs);
        self
    }

    /// A board with a [`RunCost`] lets two steps come a quarter closer than they are planned: who
    /// came late would else come later at each step.
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
