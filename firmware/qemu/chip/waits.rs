//! Measures how long a program's own interrupt waits, for an observer of stores: a part of the
//! programs `urgent` of several chips.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// The number of distinct waits, from 0 on. A longer wait is reported as the longest.
const WAITS: usize = 1024;

/// An interrupt by its own timer, at moments unrelated to the steps. A store to byte N of this is a
/// wait of N.
#[repr(C)]
pub struct Waits {
    told: [AtomicU8; WAITS],
    seed: AtomicU32,
}

impl Waits {
    /// No waits yet.
    pub const fn new() -> Waits {
        Waits { told: [const { AtomicU8::new(0) }; WAITS], seed: AtomicU32::new(1) }
    }

    /// Reports a wait. Called by one interrupt only.
    #[inline(always)]
    pub fn tell(&self, wait: u32) {
        self.told[(wait as usize).min(WAITS - 1)].store(1, Ordering::Relaxed);
    }

    /// A random number of `bits` bits, used until the next wait. Called by that interrupt only.
    #[inline(always)]
    pub fn luck(&self, bits: u32) -> u32 {
        let seed = self.seed.load(Ordering::Relaxed);
        let seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.seed.store(seed, Ordering::Relaxed);
        seed.wrapping_shr(32 - bits)
    }
}
