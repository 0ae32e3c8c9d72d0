//! Interrupt handlers: in Rust, or in assembly placed at a vector by its name.

/// Declares a handler in Rust: the name of its vector on the Uno and on the Mega, and its body.
#[cfg(feature = "uno")]
#[doc(hidden)]
#[macro_export]
macro_rules! handler {
    ($uno:ident, $mega:ident, $body:expr) => {
        // Not public, so it needs no documentation.
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

/// The vectors of a received byte, and of room to send.
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

/// The first literal on the Uno, the second on the Mega.
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

/// The 4 cycles of a handler's entry. simavr enters it in no time; the feature `bench` spends them
/// here, so that measured figures match the chip.
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
    // SAFETY: it changes no register and no memory.
    unsafe { core::arch::asm!(entry!(), options(nomem, nostack, preserves_flags)) };
}
