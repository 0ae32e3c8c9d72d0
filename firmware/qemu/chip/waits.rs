//! How long an interrupt of a program's own waits, for whoever watches stores: a part of the programs
//! `urgent` of several chips.

use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

/// Waits that are told apart, from 0 on. A longer one is told as the longest.
const WAITS: usize = 1024;

/// An interrupt by a timer of its own, at moments that have nothing to do with the steps'. A store to byte
/// N of it is a wait of N.
#[repr(C)]
pub struct Waits {
    told: [AtomicU8; WAITS],
    seed: AtomicU32,
}

impl Waits {
    /// None yet.
    pub const fn new() -> Waits {
        Waits { told: [const { AtomicU8::new(0) }; WAITS], seed: AtomicU32::new(1) }
    }

    /// Tells a wait. Called by one interrupt alone.
    #[inline(always)]
    pub fn tell(&self, wait: u32) {
        self.told[(wait as usize).min(WAITS - 1)].store(1, Ordering::Relaxed);
    }

    /// A random number of `bits` bits: until the next one. Called by that interrupt alone.
    #[inline(always)]
    pub fn luck(&self, bits: u32) -> u32 {
        let seed = self.seed.load(Ordering::Relaxed);
        let seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        self.seed.store(seed, Ordering::Relaxed);
        seed.wrapping_shr(32 - bits)
    }
}
