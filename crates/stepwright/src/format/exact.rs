//! The representation for chips of 32 bits and more, and for a host.

use core::sync::atomic::{AtomicU8, Ordering};

use crate::entry::Play;
use crate::units::Ticks;

/// Ticks that a step costs.
pub(crate) type Step = Ticks;

/// Converts to ticks.
pub(crate) const fn wide(ticks: Step) -> Ticks {
    ticks
}

/// Converts from ticks.
pub(crate) const fn step_ticks(ticks: Ticks) -> Step {
    ticks
}

/// Bytes of a wait in an entry, which has 16 fractional bits.
pub(crate) const BYTES: usize = 4;

/// Groups of an entry, at least one.
pub(crate) type Groups = u32;

/// Groups that are left of an entry.
pub(crate) type Left = u32;

/// A wait in 2⁻¹⁶ ticks: of one event, or of many on a wide counter.
pub(crate) type Wait = u64;

/// Half of a wait, in ticks.
pub(crate) type Half = u32;

/// Encodes a number of groups, 1 … 65536.
pub(crate) const fn groups(count: u32) -> Groups {
    count
}

/// The number of groups.
pub(crate) const fn count(groups: Groups) -> u32 {
    groups
}

/// Ticks before a far step at which an empty queue is read again: enough to fetch the step at any
/// timer rate, and a small part of a planner's horizon.
pub(crate) const EARLY: Ticks = 4_096;

/// The wait of this event and of the waits of the same length after it: less than `hop` ticks in
/// all, as a wide counter need not wait in pieces.
#[inline(always)]
pub(crate) fn joined(wait: Wait, play: &mut Play, hop: Ticks) -> Wait {
    play.join(wait as u32, u64::from(hop) << 16)
}

/// Steps after the next event that are like it, taken out of their entry: each wait is longer than
/// the previous one by the same amount. They are all played by the [short path](crate::engine).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Alike {
    count: u32,
    growth: u32,
}

impl Alike {
    pub(crate) const NONE: Alike = Alike { count: 0, growth: 0 };

    /// Takes them out of the rest of an entry, whose last event was one of `step`.
    #[inline(always)]
    pub(crate) fn of(play: &mut Play, step: u8) -> Alike {
        let (count, growth) = play.take_alike(step);
        Alike { count, growth }
    }

    /// The number of steps.
    #[inline(always)]
    pub(crate) const fn count(self) -> u32 {
        self.count
    }

    /// The wait of the first of them; `behind` is the wait of the event after them all.
    pub(crate) fn before(self, behind: u32) -> u32 {
        behind.wrapping_sub(self.growth.wrapping_mul(self.count))
    }

    /// Takes out one step, of which there is at least one, and returns its wait; `wait` is the one
    /// before it.
    #[inline(always)]
    pub(crate) fn next(&mut self, wait: Wait) -> Wait {
        self.count = self.count.wrapping_sub(1);
        (wait as u32).wrapping_add(self.growth).into()
    }

    /// Puts back the step with this wait, and returns the wait before it.
    pub(crate) fn undo(&mut self, wait: Wait) -> Wait {
        self.count = self.count.wrapping_add(1);
        (wait as u32).wrapping_sub(self.growth).into()
    }
}

/// Kept between visits by an engine on a wide counter.
#[derive(Debug)]
pub(crate) struct Kept<T>(T);

impl<T> Kept<T> {
    pub(crate) const fn new(value: T) -> Kept<T> {
        Kept(value)
    }

    #[inline(always)]
    pub(crate) const fn get(&self) -> Option<&T> {
        Some(&self.0)
    }

    #[inline(always)]
    pub(crate) const fn get_mut(&mut self) -> Option<&mut T> {
        Some(&mut self.0)
    }
}

/// Whether a player is prompt: see [`Wiring::prompt`](crate::entry::Wiring::prompt).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Prompt(bool);

impl Prompt {
    pub(crate) const NO: Prompt = Prompt(false);
    pub(crate) const YES: Prompt = Prompt(true);

    #[inline(always)]
    pub(crate) const fn is(self) -> bool {
        self.0
    }
}

/// A byte that one side writes and the other reads. What was written before it is visible to its
/// reader.
pub(crate) struct Shared(AtomicU8);

impl Shared {
    pub(crate) const fn new() -> Shared {
        Shared(AtomicU8::new(0))
    }

    #[inline]
    pub(crate) fn get(&self) -> u8 {
        #[cfg(test)]
        crate::queue::entries::tests::before_a_read();
        self.0.load(Ordering::Acquire)
    }

    #[inline]
    pub(crate) fn set(&self, byte: u8) {
        self.0.store(byte, Ordering::Release);
    }
}
