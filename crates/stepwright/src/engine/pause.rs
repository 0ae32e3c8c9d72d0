//! Holding all axes up, and going on as if no time had passed.
//!
//! ```text
//!   deadlines   ┊ ┊ ┊ │freeze         thaw│ ┊ ┊ ┊
//!                     └──── any time ─────┘
//! ```
//!
//! Deadlines are kept relative to the present, so the pause may outlast the
//! counter many times over. Nothing is asked while the engine runs: a frozen
//! axis is an idle one.

use super::Engine;
use super::track::Event;
use crate::drive::Drive;
use crate::queue::Feed;
use crate::timer::{Count, StepTimer};
use crate::units::Ticks;

/// What the axes of a frozen engine wait for.
#[derive(Clone, Copy, Debug)]
pub struct Frozen<C: Count, const N: usize> {
    at: C,
    events: [Event; N],
}

impl<T: StepTimer, D: Drive, F: Feed, const N: usize> Engine<T, D, F, N> {
    /// Holds all axes up between two steps. Until [`thaw`](Engine::thaw) they
    /// report to be idle, and their positions are not to be asked for.
    #[must_use = "the axes go on with `thaw` only"]
    pub fn freeze(&mut self) -> Frozen<T::Count, N> {
        let at = self.timer.now();
        let mut frozen = Frozen { at, events: [Event::Idle; N] };
        for (track, event) in self.tracks.iter_mut().zip(&mut frozen.events) {
            *event = core::mem::replace(&mut track.event, Event::Idle);
        }
        self.wake_from_outside(at);
        frozen
    }

    /// Goes on: every deadline comes later by the time that has passed.
    pub fn thaw(&mut self, frozen: Frozen<T::Count, N>) {
        let now = self.timer.now();
        // Modulo the counter, as deadlines are.
        let passed = now.since(frozen.at) as Ticks;
        for (track, event) in self.tracks.iter_mut().zip(frozen.events) {
            if event != Event::Idle {
                track.due = T::Count::delayed(track.due, passed);
                track.event = event;
            }
        }
        self.wake_from_outside(now);
    }

    /// The feeds of the axes.
    pub fn feeds(&mut self) -> &mut [F; N] {
        &mut self.feeds
    }
}
