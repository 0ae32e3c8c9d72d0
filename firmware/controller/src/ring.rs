//! The received bytes of a serial line, from its interrupt to the main loop.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, AtomicU8, Ordering};

use stepwright_device::main_loop::Received;

/// The bytes that a ring holds, a power of two up to 128.
const LEN: u8 = 64;

/// Stored in place of a lost or damaged byte: no line contains it.
const GARBLED: u8 = 0xFF;

/// A ring of received bytes: one interrupt puts them in, one main loop takes them out.
pub struct Ring {
    bytes: UnsafeCell<[u8; LEN as usize]>,
    /// The counts of bytes put in and taken out, modulo 256; each has one writer.
    put: AtomicU8,
    taken: AtomicU8,
    /// There was no room for a byte. Only the interrupt uses it.
    lost: AtomicBool,
}

// SAFETY: a place is written while `put - taken < LEN` leaves it free, by the one interrupt, and
// read while `put - taken > 0` says that it is filled, by the one main loop.
unsafe impl Sync for Ring {}

impl Ring {
    /// An empty ring.
    pub const fn new() -> Ring {
        Ring {
            bytes: UnsafeCell::new([0; LEN as usize]),
            put: AtomicU8::new(0),
            taken: AtomicU8::new(0),
            lost: AtomicBool::new(false),
        }
    }

    /// Puts in a received byte.
    ///
    /// # Safety
    /// Called by one interrupt only.
    pub unsafe fn put(&self, byte: u8) {
        let put = self.put.load(Ordering::Relaxed);
        if put.wrapping_sub(self.taken.load(Ordering::Acquire)) >= LEN {
            return self.lost.store(true, Ordering::Relaxed);
        }
        let lost = self.lost.load(Ordering::Relaxed);
        self.lost.store(false, Ordering::Relaxed);
        let byte = if lost { GARBLED } else { byte };
        // SAFETY: the place is free, and within the array.
        unsafe { self.bytes.get().cast::<u8>().add((put & (LEN - 1)).into()).write(byte) };
        self.put.store(put.wrapping_add(1), Ordering::Release);
    }

    /// Puts in a damaged byte.
    ///
    /// # Safety
    /// Called by that interrupt only.
    pub unsafe fn put_garbled(&self) {
        // SAFETY: the caller's promise.
        unsafe { self.put(GARBLED) };
    }

    /// Takes out the next byte, if there is one.
    ///
    /// # Safety
    /// Called by the main loop only.
    pub unsafe fn take(&self) -> Option<Received> {
        let taken = self.taken.load(Ordering::Relaxed);
        if self.put.load(Ordering::Acquire) == taken {
            return None;
        }
        // SAFETY: the place is filled, and within the array.
        let byte = unsafe { self.bytes.get().cast::<u8>().add((taken & (LEN - 1)).into()).read() };
        self.taken.store(taken.wrapping_add(1), Ordering::Release);
        Some(if byte == GARBLED { Received::Garbled } else { Received::Byte(byte) })
    }
}

impl Default for Ring {
    fn default() -> Self {
        Ring::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(ring: &Ring) -> impl Iterator<Item = Received> {
        // SAFETY: one thread puts and takes.
        core::iter::from_fn(|| unsafe { ring.take() })
    }

    #[test]
    fn what_is_lost_is_told_in_its_place() {
        let ring = Ring::new();
        for round in 0..10 {
            for n in 0..70 {
                // SAFETY: one thread puts and takes.
                unsafe { ring.put(n) };
            }
            let first = if round == 0 { Received::Byte(0) } else { Received::Garbled };
            assert!(all(&ring).eq([first].into_iter().chain((1..LEN).map(Received::Byte))));
        }
        // SAFETY: as above.
        unsafe { (ring.put(7), ring.put(8), ring.put_garbled(), ring.put(9)) };
        let rest = [Received::Garbled, Received::Byte(8), Received::Garbled, Received::Byte(9)];
        assert!(all(&ring).eq(rest));
    }
}
