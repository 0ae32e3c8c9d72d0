//! RAM that no start-up code clears: it outlasts a reset, and no loss of power.

use core::cell::UnsafeCell;

use stepwright_device::{Mark, Store};

/// What is kept.
struct Kept(UnsafeCell<(u16, [u8; Store::SIZE as usize])>);

// SAFETY: the main loop alone touches it, through one `PortIo`.
unsafe impl Sync for Kept {}

/// `cortex-m-rt` and `riscv-rt` leave this section as it was. At power-up it holds anything, which
/// a mark and a copy of settings with its checksum tell from their own.
#[cfg_attr(target_os = "none", unsafe(link_section = ".uninit.stepwright"))]
static KEPT: Kept = Kept(UnsafeCell::new((0, [0; Store::SIZE as usize])));

/// The mark.
pub(crate) fn mark() -> Mark {
    // SAFETY: the main loop's alone; volatile, as a reset may come between any two accesses.
    Mark(unsafe { (&raw const (*KEPT.0.get()).0).read_volatile() })
}

/// Sets the mark.
pub(crate) fn set_mark(mark: Mark) {
    // SAFETY: likewise.
    unsafe { (&raw mut (*KEPT.0.get()).0).write_volatile(mark.0) }
}

/// The byte at an address; 0xFF beyond the end.
pub(crate) fn byte(address: u16) -> u8 {
    if address >= Store::SIZE {
        return 0xFF;
    }
    // SAFETY: likewise, and within the array.
    unsafe { (&raw const (*KEPT.0.get()).1).cast::<u8>().add(address.into()).read_volatile() }
}

/// Writes a byte; nothing beyond the end.
pub(crate) fn set_byte(address: u16, byte: u8) {
    if address < Store::SIZE {
        // SAFETY: likewise, and within the array.
        unsafe {
            (&raw mut (*KEPT.0.get()).1).cast::<u8>().add(address.into()).write_volatile(byte);
        }
    }
}
