//! The watchdog: resets the chip when the main loop has not fed it for half a second.

use core::arch::asm;

use avr_device::interrupt;

use crate::chip::WDT;

/// WDCE and WDE: allow a change.
const CHANGE: u8 = 1 << 4 | 1 << 3;
/// WDE, and 64 K cycles of 128 kHz: 0.5 s.
const HALF_A_SECOND: u8 = 1 << 3 | 0b101;

/// Starts the watchdog.
pub fn start(registers: &WDT) {
    feed();
    interrupt::free(|_| {
        // SAFETY: two writes to a register of ours. The second must come within 4 cycles of the
        // first; it takes 2, whatever the compiler does.
        unsafe {
            asm!(
                "st Z, {change}",
                "st Z, {time}",
                change = in(reg) CHANGE,
                time = in(reg) HALF_A_SECOND,
                in("Z") registers.wdtcsr().as_ptr(),
                options(nostack, preserves_flags),
            );
        }
    });
}

/// Restarts the half second.
#[inline(always)]
pub fn feed() {
    avr_device::asm::wdr();
}
