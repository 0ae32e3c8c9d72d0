//! The state of planning a run.

use super::bent::Bent;
use crate::num::Num;
use crate::run::Run;

/// A run that is being planned: one for all axes, which take turns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Work {
    /// The speed at the end of a ramp run.
    pub(super) pending: Num,
    /// The mean interval of a run.
    pub(super) mean: Num,
    /// δ of a ramp run, divided by its steps, or the time of a corner.
    pub(super) delta: Num,
    /// The time of the end of a run of a bent ramp, from the low end.
    pub(super) time: Bent,
    /// The run: first its steps and its growth, an even number; then its first interval.
    pub(super) run: Run,
    /// Units of the horizon that the run lasts.
    pub(crate) span: u8,
    /// How far the planning of the run is.
    pub(super) stage: Stage,
}

impl Work {
    pub(crate) const NONE: Work = Work {
        pending: Num::UNSET,
        mean: Num::UNSET,
        delta: Num::UNSET,
        time: Bent::UNSET,
        run: Run { ticks: 0, part: 0, count: 0, add: 0 },
        span: 0,
        stage: Stage::Begin,
    };

    /// Whether a run is being planned; then there is room for it.
    pub(crate) fn is_begun(&self) -> bool {
        self.stage != Stage::Begin
    }

    /// Keeps the axis as the one that is planned until the work is [cleared](Work::clear).
    pub(crate) fn begin(&mut self) {
        self.stage = Stage::Half;
    }

    /// The run that has been [taken](super::Planner::take), until it is [queued](Work::clear): the
    /// planner is already past it.
    pub(crate) fn taken(&self) -> Option<&Run> {
        (self.stage == Stage::Taken).then_some(&self.run)
    }

    /// Steps of the run.
    pub(crate) fn steps(&self) -> u16 {
        self.run.count
    }

    /// Forgets a run that is being planned, because the travel has changed. A run that has been
    /// taken is a part of the travel, and stays.
    pub(crate) fn drop(&mut self) {
        if self.stage != Stage::Taken {
            self.clear();
        }
    }

    /// Forgets everything: the run is in its queue, or its axis has been killed.
    pub(crate) fn clear(&mut self) {
        self.stage = Stage::Begin;
    }
}

/// How far the planning of a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Not begun.
    Begin,
    /// Known or guessed: the speed at the end of a ramp run; the interval of the level; the time of
    /// the rise and level of a corner.
    Half,
    /// All values of a ramp run are known.
    Late,
    /// The run has been taken, and is to be queued.
    Taken,
}

/// The result of [`Planner::next`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Planned {
    /// A run: [`take`](super::Planner::take) it now.
    Ready,
    /// Nothing yet: call again. A run takes three calls or more, so that no call takes a chip long.
    Again,
    /// The travel is planned to its end.
    End,
}
