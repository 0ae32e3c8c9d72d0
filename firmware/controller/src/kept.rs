//! RAM that no start-up code clears: it outlasts a reset, but no loss of power.

use core::cell::UnsafeCell;

use stepwright_device::{Mark, Reset, ResetIo, Store};

/// The kept bytes: the mark and the settings.
struct Kept(UnsafeCell<(u16, [u8; Store::SIZE as usize])>);

// SAFETY: only the main loop uses it, through one `PortIo`.
unsafe impl Sync for Kept {}

/// `cortex-m-rt` and `riscv-rt` do not change this section. At power-up it holds anything, which is
/// distinguished from a mark and from a copy of settings with its checksum.
#[cfg_attr(target_os = "none", unsafe(link_section = ".uninit.stepwright"))]
static KEPT: Kept = Kept(UnsafeCell::new((0, [0; Store::SIZE as usize])));

/// The mark.
pub(crate) fn mark() -> Mark {
    // SAFETY: only the main loop uses it; volatile, because a reset may come between any two
    // accesses.
    Mark(unsafe { (&raw const (*KEPT.0.get()).0).read_volatile() })
}

/// Sets the mark.
pub(crate) fn set_mark(mark: Mark) {
    // SAFETY: as above.
    unsafe { (&raw mut (*KEPT.0.get()).0).write_volatile(mark.0) }
}

/// The byte at an address; 0xFF beyond the end.
pub(crate) fn byte(address: u16) -> u8 {
    if address >= Store::SIZE {
        return 0xFF;
    }
    // SAFETY: as above, and within the array.
    unsafe { (&raw const (*KEPT.0.get()).1).cast::<u8>().add(address.into()).read_volatile() }
}

/// Writes a byte; nothing beyond the end.
pub(crate) fn set_byte(address: u16, byte: u8) {
    if address < Store::SIZE {
        // SAFETY: as above, and within the array.
        unsafe {
            (&raw mut (*KEPT.0.get()).1).cast::<u8>().add(address.into()).write_volatile(byte);
        }
    }
}

/// The kept mark, and the reason of the last reset, for a program that is not the controller.
pub(crate) struct KeptMark(pub(crate) Reset);

impl ResetIo for KeptMark {
    fn reset(&mut self) -> Reset {
        self.0
    }

    fn mark(&self) -> Mark {
        mark()
    }

    fn set_mark(&mut self, mark: Mark) {
        set_mark(mark);
    }
}
