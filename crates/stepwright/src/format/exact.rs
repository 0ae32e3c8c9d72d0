//! Of chips of 32 bits and more, and of a host.

use core::sync::atomic::{AtomicU8, Ordering};

use crate::entry::Play;
use crate::units::Ticks;

/// Bytes of a wait in an entry, which has 16 bits behind the point.
pub(crate) const BYTES: usize = 4;

/// Groups of an entry, at least one.
pub(crate) type Groups = u32;

/// Groups that are left of an entry.
pub(crate) type Left = u32;

/// A wait in 2⁻¹⁶ ticks: of one event, or on wide counters of many.
pub(crate) type Wait = u64;

/// Half of a wait, in ticks.
pub(crate) type Half = u32;

/// This many groups, 1 … 65536.
pub(crate) const fn groups(count: u32) -> Groups {
    count
}

/// How many they are.
pub(crate) const fn count(groups: Groups) -> u32 {
    groups
}

/// The wait of this event, and of those after it that are waits of the same length: less than
/// `hop` ticks in all, as a wide counter need not wait in pieces.
#[inline(always)]
pub(crate) fn joined(wait: Wait, play: &mut Play, hop: Ticks) -> Wait {
    wait * (1 + play.leave_out(wait, u64::from(hop) << 16))
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

/// A byte that one side writes and the other reads; what was written before it
/// is seen by who reads it.
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
