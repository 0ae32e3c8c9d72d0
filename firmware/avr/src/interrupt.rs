//! Interrupt handlers.

/// Declares a handler: its vector's name on the Uno, on the Mega, and what it
/// does.
///
/// simavr enters a handler in no time; the chip takes 4 cycles. The feature
/// `bench` spends them here, so that measured figures are the chip's.
#[doc(hidden)]
#[macro_export]
macro_rules! handler {
    ($uno:ident, $mega:ident, $body:expr) => {
        // Not public, and so in need of no documentation.
        const _: () = {
            #[cfg(feature = "uno")]
            #[avr_device::interrupt(atmega328p)]
            fn $uno() {
                $crate::interrupt::entry();
                $body
            }
            #[cfg(feature = "mega")]
            #[avr_device::interrupt(atmega2560)]
            fn $mega() {
                $crate::interrupt::entry();
                $body
            }
        };
    };
}
/// The 4 cycles of an interrupt's entry, for a simulator that leaves them out.
#[inline(always)]
pub fn entry() {
    #[cfg(feature = "bench")]
    // SAFETY: jumps to the next instruction, twice, 2 cycles each.
    unsafe {
        core::arch::asm!("rjmp .+0", "rjmp .+0", options(nomem, nostack, preserves_flags))
    };
}
