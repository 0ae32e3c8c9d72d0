//! The representation for an 8-bit chip with one core.

use core::cell::UnsafeCell;
use core::marker::PhantomData;
use core::sync::atomic::{Ordering, compiler_fence};

use crate::entry::Play;
use crate::units::Ticks;

/// Ticks that a step costs: some milliseconds at most.
pub(crate) type Step = u16;

/// Converts to ticks.
pub(crate) const fn wide(ticks: Step) -> Ticks {
    ticks as Ticks
}

/// Converts from ticks, saturating.
pub(crate) const fn step_ticks(ticks: Ticks) -> Step {
    if ticks > Step::MAX as Ticks { Step::MAX } else { ticks as Step }
}

/// Bytes of a wait in an entry, which has 8 fractional bits.
pub(crate) const BYTES: usize = 3;

/// Groups of an entry; 0 stands for 256.
pub(crate) type Groups = u8;

/// Groups that are left of an entry, at most 256.
pub(crate) type Left = u16;

/// A wait in 2⁻¹⁶ ticks.
pub(crate) type Wait = u32;

/// Half of a wait, in ticks.
pub(crate) type Half = u16;

/// Encodes a number of groups, 1 … 256.
#[inline(always)]
pub(crate) const fn groups(count: u32) -> Groups {
    count as u8
}

/// The number of groups.
#[inline(always)]
pub(crate) const fn count(groups: Groups) -> u32 {
    if groups == 0 { 256 } else { groups as u32 }
}

/// No empty queue is read early.
pub(crate) const EARLY: Ticks = 0;

/// The wait of this event alone.
#[inline(always)]
pub(crate) fn joined(wait: Wait, _: &mut Play, _: Ticks) -> Wait {
    wait
}

/// Nothing: no steps are taken out of their entry, because no counter is wide.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Alike;

impl Alike {
    pub(crate) const NONE: Alike = Alike;

    #[inline(always)]
    pub(crate) fn of(_: &mut Play, _: u8) -> Alike {
        Alike
    }

    #[inline(always)]
    pub(crate) const fn count(self) -> u32 {
        0
    }

    #[inline(always)]
    pub(crate) fn before(self, behind: u32) -> u32 {
        behind
    }

    #[inline(always)]
    pub(crate) fn next(&mut self, wait: Wait) -> Wait {
        wait
    }

    pub(crate) fn undo(&mut self, wait: Wait) -> Wait {
        wait
    }
}

/// Nothing is kept between visits.
#[derive(Debug)]
pub(crate) struct Kept<T>(PhantomData<T>);

impl<T: Copy> Kept<T> {
    pub(crate) const fn new(_: T) -> Kept<T> {
        Kept(PhantomData)
    }

    #[inline(always)]
    pub(crate) const fn get(&self) -> Option<&T> {
        None
    }

    #[inline(always)]
    pub(crate) const fn get_mut(&mut self) -> Option<&mut T> {
        None
    }
}

/// No player is prompt: there is nothing to store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Prompt;

impl Prompt {
    pub(crate) const NO: Prompt = Prompt;
    pub(crate) const YES: Prompt = Prompt;

    #[inline(always)]
    pub(crate) const fn is(self) -> bool {
        false
    }
}

/// A byte that one side writes and the other reads. What was written before it is visible to its
/// reader. Reading or writing it is one instruction, and there are only an interrupt and a
/// foreground: an atomic would make the compiler hold interrupts off.
pub(crate) struct Shared(UnsafeCell<u8>);

impl Shared {
    pub(crate) const fn new() -> Shared {
        Shared(UnsafeCell::new(0))
    }

    #[inline(always)]
    pub(crate) fn get(&self) -> u8 {
        // SAFETY: one instruction; there are only an interrupt and a foreground.
        let byte = unsafe { self.0.get().read_volatile() };
        compiler_fence(Ordering::Acquire);
        byte
    }

    #[inline(always)]
    pub(crate) fn set(&self, byte: u8) {
        compiler_fence(Ordering::Release);
        // SAFETY: as above.
        unsafe { self.0.get().write_volatile(byte) };
    }
}
