//! Late steps and empty queues.

use super::track::{State, Track};
use super::{BEHIND, Engine, FACE, POLL, STEP, TURN, Timing};
use crate::drive::Drive;
use crate::format::{EARLY, Wait};
use crate::late::late_after;
use crate::queue::Source;
use crate::timer::{Count, StepTimer};
use crate::units::{Rate, Ticks};

/// The times that all axes keep, and the number of late steps.
pub(super) struct Terms {
    pub timing: Timing,
    /// The minimum interval; half the counter, if that is less.
    pub least: Ticks,
    /// 1 µs in ticks; then [`BEHIND`] and [`POLL`] in ticks.
    grace: Ticks,
    slip: Ticks,
    pub poll: Ticks,
    pub late: u32,
    /// Whether a travel has ended or a step was late since the interrupt began.
    pub news: bool,
}

impl Terms {
    pub const fn new<C: Count>(timing: Timing, rate: Rate) -> Terms {
        Terms {
            timing,
            least: least::<C>(timing.min_interval),
            grace: late_after(0, rate),
            slip: rate.micros(BEHIND),
            poll: rate.nanos(POLL),
            late: 0,
            news: false,
        }
    }

    pub fn set_timing<C: Count>(&mut self, timing: Timing) {
        (self.timing, self.least) = (timing, least::<C>(timing.min_interval));
    }

    /// Counts a step that was late or did not come.
    pub fn count_late(&mut self) {
        self.late = self.late.saturating_add(1);
        self.news = true;
    }
}

const fn least<C: Count>(interval: Ticks) -> Ticks {
    let most = 2 * C::HOP - 1;
    if interval < most { interval } else { most }
}

impl<C: Count> Track<C> {
    /// Judges a step that was made at `edge`. `wait` is the wait to the next deadline in 2⁻¹⁶
    /// ticks, or 0 if it is unknown: then the wait before the step counts.
    #[inline(never)]
    pub(super) fn judge(&mut self, terms: &mut Terms, wait: Wait, edge: C) {
        let mut ahead = C::of(self.due).since(edge);
        if EARLY != 0 {
            ahead = ahead.wrapping_add(self.early() as i32);
        }
        let room = self.room as i32;
        let left = if wait == 0 { ahead.wrapping_add(2 * room) } else { ahead };
        // If half an interval is less than 1 µs, the limit is the next deadline.
        if left < (room - terms.grace as i32).max(0) {
            terms.count_late();
        }
        // The next step comes at its deadline or the minimum interval after this one, whichever is
        // later; so does a turn, with the hold time. The schedule stays.
        if ahead < -(terms.slip as i32) {
            // Too far behind: the schedule shifts.
            self.due = C::delayed(self.due, ahead.unsigned_abs());
        }
        let least = match self.pins {
            _ if self.state != State::Play => 0,
            pins if pins & STEP != 0 => terms.timing.min_interval,
            pins if pins & (TURN | FACE) != 0 => terms.timing.hold,
            _ => 0,
        };
        let short = least as i32 - C::of(self.due).since(edge);
        self.push = if short > 0 && least > 0 { short.unsigned_abs() } else { 0 };
    }
}

impl<T: StepTimer, D: Drive, S: Source, const N: usize> Engine<T, D, S, N> {
    /// Ticks since the first event that is due and not served yet; 0 if there is none. Correct up
    /// to half the counter.
    #[inline(never)] // interrupts that do not call it need not save its registers
    pub fn behind(&mut self) -> Ticks {
        let now = self.timer.now();
        let tracks = self.tracks.iter().filter(|track| track.state != State::Idle);
        let behind = tracks.map(|track| now.since(track.wake())).max();
        behind.unwrap_or(0).max(0).unsigned_abs()
    }
}
