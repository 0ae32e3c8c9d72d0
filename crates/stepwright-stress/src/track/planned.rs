//! The part of the motion that a board may have planned when an order comes, by the documentation: all that
//! begins within the horizon, a run of it to its end, and the present step and the next.
//!
//! ```text
//!   told              horizon       one run
//!    ├───────────────────┼──────────────┤
//!   ─┴┬─────┬──────┬──────────────┬─ ─ ─ ─       each begins within the horizon: planned
//!  ───┴──────────────────────────────┬──────────────────────┬── the present step and the next
//! ```

use crate::limits::{HORIZON, RUN, VISIT};

/// A planned part, until it is played.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planned {
    /// An interval that begins before this time is planned.
    begins: u64,
    /// A run of such intervals is planned up to this time.
    ends: u64,
    /// A limit of jerk delays the acceleration, but not in an interval that begins after this time.
    bends: u64,
    /// The number of steps that are planned in any case.
    steps: u8,
}

impl Planned {
    /// What is planned at `now`. A wait for a first step counts as a present step. A limit of jerk bends
    /// the motion for `bend` seconds after what is planned; with slow steps not before `slow`.
    pub(super) fn new(now: u64, waits: bool, hz: f64, bend: f64, slow: u64) -> Planned {
        let after = |seconds: f64| now + ((seconds + VISIT) * hz) as u64;
        let steps = if waits { 1 } else { 2 };
        let bends = if bend > 0.0 { after(HORIZON + RUN + bend).max(slow) } else { 0 };
        Planned { begins: after(HORIZON), ends: after(HORIZON + RUN), bends, steps }
    }

    /// Whether an interval may be planned.
    pub(super) fn has(&self, from: Option<u64>, to: u64) -> bool {
        let begins = self.begins.max(self.bends);
        self.steps > 0 || to <= self.ends || from.is_some_and(|from| from <= begins)
    }

    /// Takes note of a step. It may be the first of a leg, after which nothing was planned beyond the
    /// horizon.
    pub(super) fn step(&mut self, begins: bool) {
        self.steps = if begins { 0 } else { self.steps.saturating_sub(1) };
    }

    /// Whether all of it is played if the last step was at `last`.
    pub(super) fn is_played(&self, last: u64) -> bool {
        self.steps == 0 && last > self.ends.max(self.bends)
    }
}
