//! Pauses all axes, and continues as if no time had passed.
//!
//! ```text
//!   deadlines   ┊ ┊ ┊ │freeze         thaw│ ┊ ┊ ┊
//!                     └──── any time ─────┘
//! ```
//!
//! Deadlines are kept relative to the time of the pause, so it may be longer than the counter many
//! times over. The running engine makes no extra check: a frozen axis is an idle one.

use super::track::State;
use super::{Engine, STEP};
use crate::drive::Drive;
use crate::queue::{Asked, Feed, Source};
use crate::timer::{Count, StepTimer};
use crate::units::Ticks;

/// The states of the axes of a frozen engine.
#[derive(Clone, Copy, Debug)]
pub struct Frozen<C: Count, const N: usize> {
    at: C,
    states: [State; N],
}

impl<C: Count, const N: usize> Frozen<C, N> {
    /// The same pause, after which the axes continue `ticks` later, at most [`HOP`](Count::HOP).
    #[must_use = "the axes go on with `thaw` only"]
    pub fn later(self, ticks: Ticks) -> Self {
        Frozen { at: self.at.plus(ticks.wrapping_neg()), ..self }
    }
}

impl<T: StepTimer, D: Drive, S: Source, const N: usize> Engine<T, D, S, N> {
    /// Pauses all axes between two steps. Until [`thaw`](Engine::thaw) they are reported as idle.
    #[must_use = "the axes go on with `thaw` only"]
    pub fn freeze(&mut self) -> Frozen<T::Count, N> {
        let at = self.timer.now();
        let mut frozen = Frozen { at, states: [State::Idle; N] };
        for (track, state) in self.tracks.iter_mut().zip(&mut frozen.states) {
            *state = core::mem::replace(&mut track.state, State::Idle);
        }
        self.wake_from_outside(at);
        frozen
    }

    /// Continues: every deadline moves by the time that has passed.
    pub fn thaw(&mut self, frozen: Frozen<T::Count, N>) {
        let now = self.timer.now();
        // Modulo the counter, as deadlines are.
        let passed = now.since(frozen.at) as Ticks;
        for (track, state) in self.tracks.iter_mut().zip(frozen.states) {
            if state != State::Idle {
                track.due = T::Count::delayed(track.due, passed);
                track.state = state;
            }
        }
        self.wake_from_outside(now);
    }
}

impl<T: StepTimer, D: Drive, F: Feed, const N: usize> Engine<T, D, Asked<F>, N> {
    /// The programs of the axes.
    pub fn feeds(&mut self) -> impl Iterator<Item = &mut F> {
        self.sources.iter_mut().map(|asked| &mut asked.feed)
    }

    /// The program of an axis, if there is one.
    pub fn feed(&mut self, axis: u8) -> Option<&mut F> {
        self.sources.get_mut(usize::from(axis)).map(|asked| &mut asked.feed)
    }

    /// Steps of an axis that its program has handed out and that have not been made.
    #[doc(hidden)]
    pub fn loaded(&self, axis: u8) -> u16 {
        let axis = usize::from(axis);
        let (Some(track), Some(asked)) = (self.tracks.get(axis), self.sources.get(axis)) else {
            return 0;
        };
        let playing = match track.state {
            State::Play if track.pins & STEP != 0 => {
                track.play.left().wrapping_add(track.alike.count() as u16).wrapping_add(1)
            }
            _ => 0,
        };
        asked.left().wrapping_add(playing)
    }

    /// Of the steps that the program has handed out, only the next one is still made, at its time;
    /// then the program is asked again. Returns the number of steps that are dropped.
    #[doc(hidden)]
    pub fn cut(&mut self, axis: u8) -> u16 {
        let cut = self.loaded(axis).saturating_sub(1);
        let axis = usize::from(axis);
        if let (Some(track), Some(asked)) = (self.tracks.get_mut(axis), self.sources.get_mut(axis))
            && cut > 0
        {
            if track.state == State::Play && track.pins & STEP != 0 {
                track.forget();
                asked.cut(0);
            } else {
                asked.cut(1);
            }
        }
        cut
    }
}
