//! What a board may have planned when it learns of something, as the documentation has it: all
//! that begins within the horizon, a run of it to its end, and the present step and the next.
//!
//! ```text
//!   told              horizon       one run
//!    ├───────────────────┼──────────────┤
//!   ─┴┬─────┬──────┬──────────────┬─ ─ ─ ─       each begins within the horizon: planned
//!  ───┴──────────────────────────────┬──────────────────────┬── the present step and the next
//! ```

use crate::limits::{HORIZON, RUN, VISIT};

/// What is planned, until it is played.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planned {
    /// An interval that begins before is planned.
    begins: u64,
    /// A run of them is planned up to there.
    ends: u64,
    /// A limit of jerk lets the acceleration go behind: not in an interval that begins later.
    bends: u64,
    /// This many steps are planned in any case.
    steps: u8,
}

impl Planned {
    /// At `now`; a wait for a first step is a present step. A limit of jerk bends the motion for
    /// `bend` seconds behind what is planned, and behind slow steps not before `slow`.
    pub(super) fn new(now: u64, waits: bool, hz: f64, bend: f64, slow: u64) -> Planned {
        let after = |seconds: f64| now + ((seconds + VISIT) * hz) as u64;
        let steps = if waits { 1 } else { 2 };
        let bends = if bend > 0.0 { after(HORIZON + RUN + bend).max(slow) } else { 0 };
        Planned { begins: after(HORIZON), ends: after(HORIZON + RUN), bends, steps }
    }

    /// Whether an interval may have been planned.
    pub(super) fn has(&self, from: Option<u64>, to: u64) -> bool {
        let begins = self.begins.max(self.bends);
        self.steps > 0 || to <= self.ends || from.is_some_and(|from| from <= begins)
    }

    /// A step was made; it may be the first of a leg, behind which nothing was planned beyond
    /// the horizon.
    pub(super) fn step(&mut self, begins: bool) {
        self.steps = if begins { 0 } else { self.steps.saturating_sub(1) };
    }

    /// Whether all of it is played, where the last step was then.
    pub(super) fn is_played(&self, last: u64) -> bool {
        self.steps == 0 && last > self.ends.max(self.bends)
    }
}
