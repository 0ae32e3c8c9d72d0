//! The I/O clock according to the chip's configuration.

use stepwright_timed::fit::{Oscillator, divider_of, io_clock};

use crate::chip;

/// The I/O clock in Hz, from the fuses and CLKPR, as in `motorTimerGetIOclocksPerSecond`.
pub fn io_clock_now() -> u32 {
    // SAFETY: reads a register.
    let clkpr = unsafe { chip::CPU::steal() }.clkpr().read().bits();
    let oscillator = Oscillator::from_low_fuse(low_fuse());
    io_clock(oscillator.hz(), divider_of(clkpr).unwrap_or(1)).unwrap_or(oscillator.hz())
}

/// The low fuse byte.
fn low_fuse() -> u8 {
    avr_device::interrupt::free(|_| {
        let fuse: u8;
        // SAFETY: SPMCSR is 0x37 on both chips; LPM within 3 cycles after BLBSET and SPMEN
        // reads a fuse and changes nothing.
        unsafe {
            core::arch::asm!(
                "out 0x37, {mode}",
                "lpm {fuse}, Z",
                mode = in(reg) 0b0000_1001u8,
                fuse = lateout(reg) fuse,
                in("Z") 0u16,
                options(nostack, preserves_flags),
            );
        }
        fuse
    })
}
