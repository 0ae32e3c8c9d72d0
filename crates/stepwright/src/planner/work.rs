//! How far the planning of a run is.

use crate::num::Num;

/// A run that is half planned: one for all axes, which take turns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Work {
    /// The speed at the end of a ramp run, or the time of a corner so far.
    pub(super) pending: Num,
    /// The mean interval of a run, or the speed at the end of a corner.
    pub(super) mean: Num,
    /// δ of a bent ramp's run, and when it ends, from the low end of its curve.
    #[cfg(feature = "s-curve")]
    pub(super) delta: Num,
    #[cfg(feature = "s-curve")]
    pub(super) time: Num,
    /// What the interval grows by in a step, in 2⁻¹⁶ ticks.
    pub(super) add: i32,
    /// Steps of the run.
    pub(super) steps: u16,
    /// How far its planning is.
    pub(super) stage: Stage,
}

impl Work {
    pub(crate) const NONE: Work = Work {
        pending: Num::UNSET,
        mean: Num::UNSET,
        #[cfg(feature = "s-curve")]
        delta: Num::UNSET,
        #[cfg(feature = "s-curve")]
        time: Num::UNSET,
        add: 0,
        steps: 0,
        stage: Stage::Begin,
    };

    /// Whether a run is more than half planned: there is room for it. (Of a level the interval
    /// is kept from run to run.)
    pub(crate) fn is_begun(&self) -> bool {
        matches!(self.stage, Stage::Late | Stage::Last)
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
    /// All of a ramp run is known; of a corner the time of its rise and level.
    Late,
    /// The speed at the end of a corner is known.
    Last,
}

/// What [`Planner::next`] has done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Planned {
    /// A run: [`take`](super::Planner::take) it now.
    Ready,
    /// Nothing yet: ask again. A run is made in three steps or more, so that
    /// no call takes a chip long.
    Again,
    /// The travel is planned to its end.
    End,
}
