//! How far the planning of a run is.

use crate::num::Num;
use crate::units::Ticks;

/// A run that is half planned: one for all axes, which take turns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Work {
    /// The speed at the end of a ramp run, or the time of a corner so far.
    pub(super) pending: Num,
    /// The mean interval of a run, or the speed at the end of a corner.
    pub(super) mean: Num,
    /// δ of a ramp run.
    pub(super) delta: Num,
    /// When the run ends, from the low end of its curve.
    pub(super) time: Num,
    /// How far its planning is.
    pub(super) stage: Stage,
}

impl Work {
    pub(crate) const NONE: Work = Work {
        pending: Num::UNSET,
        mean: Num::UNSET,
        delta: Num::UNSET,
        time: Num::UNSET,
        stage: Stage::Begin,
    };

    /// Whether a run is half planned: there is room for it.
    pub(crate) fn is_begun(&self) -> bool {
        self.stage != Stage::Begin
    }

    /// Forgets what has been begun: the travel has changed.
    pub(crate) fn drop(&mut self) {
        self.stage = Stage::Begin;
    }
}

/// How far the planning of a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stage {
    /// Not begun.
    Begin,
    /// The speed at the end of a ramp run is known; the interval of the level;
    /// of a corner the time of its rise.
    Half,
    /// The mean interval of a ramp run is known; of a corner the time of its
    /// rise and level.
    Late,
    /// The speed at the end of a corner is known.
    Last,
}

/// What [`Planner::next`] has done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Planned {
    /// A run, which lasts for so many ticks.
    Run(Ticks),
    /// Nothing yet: ask again. A run is made in three steps or more, so that
    /// no call takes a chip long.
    Again,
    /// The travel is planned to its end.
    End,
}
