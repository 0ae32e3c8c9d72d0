//! Steps that came late.

use super::Engine;
use super::track::Event;
use crate::drive::Drive;
use crate::queue::Feed;
use crate::timer::{Count, StepTimer};
use crate::units::Ticks;

impl<T: StepTimer, D: Drive, F: Feed, const N: usize> Engine<T, D, F, N> {
    /// Counts the step that was made `behind` ticks after `due`, if it was
    /// late, and catches up.
    #[inline(always)]
    pub(super) fn judge(&mut self, axis: usize, behind: i32, edge: T::Count) {
        let Some(track) = self.tracks.get(axis) else { return };
        let half = (track.play.interval >> 17) as i32;
        if behind > half || track.debt != 0 {
            self.fell_behind(axis, behind, half, edge);
        }
    }

    #[cold]
    #[inline(never)]
    fn fell_behind(&mut self, axis: usize, behind: i32, half: i32, edge: T::Count) {
        let Some(track) = self.tracks.get(axis) else { return };
        if behind.saturating_add(track.debt as i32) > half {
            self.late = self.late.saturating_add(1);
        }
        self.catch_up(axis, edge);
    }

    /// Moves the next step to its deadline or the minimum interval after this
    /// one, whichever is later.
    fn catch_up(&mut self, axis: usize, now: T::Count) {
        let min = self.timing.min_interval as i32;
        let Some(track) = self.tracks.get_mut(axis) else { return };
        match track.event {
            Event::Step | Event::CatchUp => {}
            // A long wait: the deadline needs no help.
            Event::Hop => {
                track.due = T::Count::delayed(track.due, track.debt.wrapping_neg());
                track.debt = 0;
                return;
            }
            Event::Turn | Event::Dry | Event::Idle => {
                track.debt = 0;
                return;
            }
        }
        let room = T::Count::of(track.due).since(now).saturating_sub(min);
        if room < 0 {
            let push = room.unsigned_abs();
            track.due = T::Count::delayed(track.due, push);
            track.debt = track.debt.saturating_add(push);
        } else {
            let pull = (room as Ticks).min(track.debt);
            track.due = T::Count::delayed(track.due, pull.wrapping_neg());
            track.debt -= pull;
        }
        if track.debt >= T::Count::HOP {
            track.debt = 0; // too far behind: the schedule slips
        }
        track.event = if track.debt == 0 { Event::Step } else { Event::CatchUp };
    }
}
