//! The reason of the last reset, and the mark that RAM keeps through it.
//!
//! The mark is placed after all other statics, because boot loaders use the two ends of RAM.

use core::mem::MaybeUninit;

use stepwright_device::{Mark, Reset, ResetIo};

use crate::chip::CPU;
use crate::slot::Slot;

/// Not cleared by the start-up code.
#[unsafe(link_section = ".noinit")]
static MARK: Slot<MaybeUninit<u16>> = Slot::new(MaybeUninit::uninit());

/// The reason of the last reset. Call it once: the next call returns [`Reset::Other`].
pub fn reason() -> Reset {
    // SAFETY: a register of the chip that only this function uses.
    let register = unsafe { CPU::steal() };
    let flags = register.mcusr().read();
    register.mcusr().reset();
    // At power-up a slowly rising supply may set other flags too.
    if flags.porf().bit_is_set() {
        Reset::Power
    } else if flags.wdrf().bit_is_set() {
        Reset::Watchdog
    } else {
        Reset::Other
    }
}

/// The mark in RAM, or the contents of its place.
pub fn mark() -> Mark {
    // SAFETY: two bytes that only the foreground reads and writes. They may hold anything, and are
    // read as a volatile number.
    Mark(unsafe { MARK.address().cast::<u16>().read_volatile() })
}

/// Sets the mark.
pub fn set_mark(mark: Mark) {
    // SAFETY: as above; the static's memory may be written.
    unsafe { MARK.address().cast::<u16>().cast_mut().write_volatile(mark.0) };
}

/// The chip's mark and reset reason, for a program that is not the controller.
pub struct RamMark;

impl ResetIo for RamMark {
    fn reset(&mut self) -> Reset {
        reason()
    }

    fn mark(&self) -> Mark {
        mark()
    }

    fn set_mark(&mut self, mark: Mark) {
        set_mark(mark);
    }
}
