//! Steps that came late, and queues that were empty.

use super::track::{State, Wait};
use super::{Engine, FACE, STEP, TURN};
use crate::drive::Drive;
use crate::queue::Source;
use crate::timer::{Count, StepTimer};
use crate::units::Ticks;

impl<T: StepTimer, D: Drive, S: Source, const N: usize> Engine<T, D, S, N> {
    /// A step was made at `edge`, with this wait in 2⁻¹⁶ ticks to the next deadline, or 0 if
    /// that is not known: then the wait before it tells.
    #[inline(never)]
    pub(super) fn judge(&mut self, axis: usize, wait: Wait, edge: T::Count) {
        let Some(track) = self.tracks.get_mut(axis) else { return };
        let ahead = T::Count::of(track.due).since(edge);
        let left = if wait == 0 { ahead.wrapping_add(2 * track.room) } else { ahead };
        // Where half an interval is less than the µs, with the next deadline.
        if left < (track.room - self.grace as i32).max(0) {
            self.late = self.late.saturating_add(1);
        }
        // The next one comes at its deadline or the minimum interval after this
        // one, whichever is later; so does a turn, by the hold time. The
        // schedule stays.
        if ahead < -(self.slip as i32) {
            // Too far behind: the schedule slips.
            track.due = T::Count::delayed(track.due, ahead.unsigned_abs());
        }
        let least = match track.pins {
            _ if track.state != State::Play => 0,
            pins if pins & STEP != 0 => self.timing.min_interval,
            pins if pins & (TURN | FACE) != 0 => self.timing.hold,
            _ => 0,
        };
        let short = least as i32 - T::Count::of(track.due).since(edge);
        track.push = if short > 0 && least > 0 { short.unsigned_abs() } else { 0 };
    }

    /// Ticks since the first event that is due and not yet served; 0 if there is
    /// none. Right up to half the counter.
    #[inline(never)] // a step interrupt that needs it not is shorter by its registers
    pub fn behind(&mut self) -> Ticks {
        let now = self.timer.now();
        let tracks = self.tracks.iter().filter(|track| track.state != State::Idle);
        let behind = tracks.map(|track| now.since(track.wake())).max();
        behind.unwrap_or(0).max(0).unsigned_abs()
    }
}
