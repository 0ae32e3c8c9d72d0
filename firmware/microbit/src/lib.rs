#![no_std]
//! No hardware was seen: these programs run in QEMU. What to check: `docs/embassy.md`.
//!
//! What the programs for the micro:bit have in common: its step timer, its pins, and a line to say
//! something on.
//!
//! | program | what |
//! | --- | --- |
//! | `bin/embassy.rs` | Embassy: moves that are awaited, joined and raced |
//! | `bin/rtic.rs` | RTIC 2: the program owns the step interrupt |
//! | `bin/bare.rs` | a main loop that sleeps |
//!
//! X steps at P15 (P0.21), Y at P14; DIR is P2 (P0.1) and P1. `cargo xtask test --only qemu` runs them, and
//! holds their edges against the virtual board's.

use core::fmt::{Arguments, Write};

use panic_halt as _;
use stepwright::{EngineHandle, SharedEngine};
pub use stepwright_nrf51::board::BOARD;
use stepwright_nrf51::pins::StepPins;
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::Uart;

/// The engine of a static, and the main loop's hold on it.
pub type Engine = SharedEngine<Timer, StepPins, StepInterrupt, 3>;
/// Likewise.
pub type Handle = EngineHandle<Timer, StepPins, StepInterrupt, 3, 8>;

/// The step timer, started, and the pins, low.
///
/// # Safety
/// Called once.
pub unsafe fn start() -> (Timer, StepPins) {
    // SAFETY: the caller's promise.
    unsafe { (Timer::start(), StepPins::new()) }
}

/// Says a line on the USB's serial port, 115200 baud.
#[macro_export]
macro_rules! say {
    ($($words:tt)*) => { $crate::send(format_args!($($words)*)) };
}

/// Sends a line.
#[doc(hidden)]
pub fn send(words: Arguments<'_>) {
    // SAFETY: the programs have no other line, and say one thing at a time.
    let mut line = unsafe { Uart::to_talk() };
    // What is written there is sent.
    let _ = line.write_fmt(words);
    let _ = line.write_char('\r');
}
