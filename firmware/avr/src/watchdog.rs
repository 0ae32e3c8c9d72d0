//! The watchdog: resets the chip when the main loop has not come by for half a
//! second.

use avr_device::interrupt;

use crate::chip::{CPU, WDT};

/// Starts the watchdog, and says whether the last reset was its doing.
///
/// A boot loader that clears `MCUSR` takes that answer away.
pub fn start(cpu: &CPU, registers: &WDT) -> bool {
    let bitten = cpu.mcusr().read().wdrf().bit_is_set();
    // While WDRF is set the watchdog can't be changed.
    cpu.mcusr().reset();
    feed();
    interrupt::free(|_| {
        // The second write must come within 4 cycles of the first.
        registers.wdtcsr().modify(|_, w| w.wdce().set_bit().wde().set_bit());
        // 64 K cycles of 128 kHz: 0.5 s.
        registers.wdtcsr().write(|w| w.wde().set_bit().wdpl().cycles_64k());
    });
    bitten
}

/// All is well for another half second.
#[inline(always)]
pub fn feed() {
    avr_device::asm::wdr();
}
