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
use crate::stride::Left;
use crate::timer::{Count, StepTimer};
use crate::units::Ticks;

/// What the axes of a frozen engine wait for.
#[derive(Clone, Copy, Debug)]
pub struct Frozen<C: Count, const N: usize> {
    at: C,
    events: [Event; N],
}

impl<C: Count, const N: usize> Frozen<C, N> {
    /// The same, to go on `ticks` later than it would, at most [`HOP`](Count::HOP).
    #[must_use = "the axes go on with `thaw` only"]
    pub fn later(self, ticks: Ticks) -> Self {
        Frozen { at: self.at.plus(ticks.wrapping_neg()), ..self }
    }
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

    /// Steps that have been loaded for an axis, and not been made; 0 if there is no such
    /// axis.
    pub fn loaded(&self, axis: u8) -> u16 {
        let axis = usize::from(axis);
        match (self.tracks.get(axis), self.feeds.get(axis)) {
            (Some(track), Some(feed)) => track.left(feed.left(&track.own)),
            _ => 0,
        }
    }

    /// Drops the steps that are loaded for an axis beyond the next one, which is made at
    /// its time; then the feed is asked for what follows. Returns the number of dropped
    /// steps. The run MUST have one interval, without growth.
    pub fn cut(&mut self, axis: u8) -> u16 {
        let cut = self.loaded(axis).saturating_sub(1);
        let axis = usize::from(axis);
        if let (Some(track), Some(feed)) = (self.tracks.get_mut(axis), self.feeds.get_mut(axis))
            && cut > 0
        {
            track.far.count = 0;
            if track.event == Event::Step {
                feed.playing(&mut track.own).stride().left = Left::new(1);
            }
            track.loaded = track.loaded.wrapping_sub(cut.into());
        }
        cut
    }

    /// The feeds of the axes.
    pub fn feeds(&mut self) -> &mut [F; N] {
        &mut self.feeds
    }
}
