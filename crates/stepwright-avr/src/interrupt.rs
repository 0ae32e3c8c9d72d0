//! Interrupt handlers: in Rust, or assembly that is put at a vector by its name.

/// Declares a handler in Rust: its vector's name on the Uno, on the Mega, and
/// what it does.
#[cfg(feature = "uno")]
#[doc(hidden)]
#[macro_export]
macro_rules! handler {
    ($uno:ident, $mega:ident, $body:expr) => {
        // Not public, and so in need of no documentation.
        const _: () = {
            #[avr_device::interrupt(atmega328p)]
            fn $uno() {
                $crate::interrupt::entry();
                $body
            }
        };
    };
}
#[cfg(feature = "mega")]
#[doc(hidden)]
#[macro_export]
macro_rules! handler {
    ($uno:ident, $mega:ident, $body:expr) => {
        const _: () = {
            #[avr_device::interrupt(atmega2560)]
            fn $mega() {
                $crate::interrupt::entry();
                $body
            }
        };
    };
}

/// The vector of a byte that came, and that of the sender's room.
#[doc(hidden)]
#[macro_export]
macro_rules! vector {
    (received) => {
        $crate::either!("__vector_18", "__vector_25")
    };
    (has_room) => {
        $crate::either!("__vector_19", "__vector_26")
    };
}

/// The one on the Uno, or the other on the Mega.
#[cfg(feature = "uno")]
#[doc(hidden)]
#[macro_export]
macro_rules! either {
    ($uno:literal, $mega:literal) => {
        $uno
    };
}
#[cfg(feature = "mega")]
#[doc(hidden)]
#[macro_export]
macro_rules! either {
    ($uno:literal, $mega:literal) => {
        $mega
    };
}

/// The 4 cycles of a handler's entry. simavr enters it in no time; the feature
/// `bench` spends them here, so that measured figures are the chip's.
#[cfg(not(feature = "bench"))]
#[doc(hidden)]
#[macro_export]
macro_rules! entry {
    () => {
        ""
    };
}
#[cfg(feature = "bench")]
#[doc(hidden)]
#[macro_export]
macro_rules! entry {
    () => {
        "rjmp .+0\nrjmp .+0"
    };
}

/// [`entry!`](crate::entry) for handlers in Rust.
#[inline(always)]
pub fn entry() {
    // SAFETY: it does nothing to a register or to memory.
    unsafe { core::arch::asm!(entry!(), options(nomem, nostack, preserves_flags)) };
}
