//! How far the planning of a run is.

use super::bent::Bent;
use crate::num::Num;
use crate::run::Run;

/// A run that is half planned: one for all axes, which take turns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Work {
    /// The speed at the end of a ramp run.
    pub(super) pending: Num,
    /// The mean interval of a run.
    pub(super) mean: Num,
    /// δ of a ramp run, divided by its steps, or the time of a corner.
    pub(super) delta: Num,
    /// When a run of a bent ramp ends, from the low end.
    pub(super) time: Bent,
    /// The run: its steps and its growth, an even number, at first; then its first interval.
    pub(super) run: Run,
    /// Units of the horizon that the run lasts.
    pub(crate) span: u8,
    /// How far its planning is.
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

    /// Whether a run is half planned: there is room for it.
    pub(crate) fn is_begun(&self) -> bool {
        self.stage != Stage::Begin
    }

    /// Its axis is the one that is planned until it is [cleared](Work::clear).
    pub(crate) fn begin(&mut self) {
        self.stage = Stage::Half;
    }

    /// The run that has been [taken](super::Planner::take), until it is
    /// [handed over](Work::clear): the planner is beyond it.
    pub(crate) fn taken(&self) -> Option<&Run> {
        (self.stage == Stage::Taken).then_some(&self.run)
    }

    /// Steps of the run.
    pub(crate) fn steps(&self) -> u16 {
        self.run.count
    }

    /// Forgets what has been begun: the travel has changed. A run that has been taken is a
    /// part of the travel, and stays.
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
    /// The speed at the end of a ramp run is known, or guessed; the interval of the level;
    /// of a corner the time of its rise and level.
    Half,
    /// All of a ramp run is known.
    Late,
    /// The run has been taken, and is to be queued.
    Taken,
}

/// What [`Planner::next`] has done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Planned {
    /// A run: [`take`](super::Planner::take) it now.
    Ready,
    /// Nothing yet: ask again. A run is made in three calls or more, so that
    /// no call takes a chip long.
    Again,
    /// The travel is planned to its end.
    End,
}
