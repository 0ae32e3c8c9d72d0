//! Steps that came late.

use super::Engine;
use super::track::Event;
use crate::drive::Drive;
use crate::queue::Feed;
use crate::timer::{Count, StepTimer};
use crate::units::Ticks;

impl<T: StepTimer, D: Drive, F: Feed, const N: usize> Engine<T, D, F, N> {
    /// A step was made at `edge`, and the next deadline, or what would be it,
    /// is `next`: counts it if less than half an interval is left between.
    #[inline(always)]
    pub(super) fn judge(&mut self, axis: usize, next: T::Count, half: i32, edge: T::Count) {
        let left = next.since(edge);
        if left < half {
            self.fell_behind(axis, left);
        }
        let Some(track) = self.tracks.get_mut(axis) else { return };
        // The next one comes at its deadline or the minimum interval after this
        // one, whichever is later; so does a turn, by the hold time. The
        // schedule stays.
        let least = match track.event {
            Event::Step => self.timing.min_interval,
            Event::Turn => self.timing.hold,
            _ => 0,
        };
        let short = least as i32 - T::Count::of(track.due).since(edge);
        track.push = if short > 0 && least > 0 { short.unsigned_abs() } else { 0 };
    }

    #[cold]
    #[inline(never)]
    fn fell_behind(&mut self, axis: usize, left: i32) {
        self.late = self.late.saturating_add(1);
        let Some(track) = self.tracks.get_mut(axis) else { return };
        if left < -(T::Count::HOP as i32) && track.event == Event::Step {
            // Too far behind: the schedule slips.
            track.due = T::Count::delayed(track.due, left.unsigned_abs());
        }
    }

    /// Ticks since the first event that is due and not yet served; 0 if there is
    /// none. Right up to half the counter.
    #[inline(never)] // a step interrupt that needs it not is shorter by its registers
    pub fn behind(&mut self) -> Ticks {
        let now = self.timer.now();
        let tracks = self.tracks.iter().filter(|track| track.event != Event::Idle);
        let behind = tracks.map(|track| now.since(track.wake())).max();
        behind.unwrap_or(0).max(0).unsigned_abs()
    }
}
