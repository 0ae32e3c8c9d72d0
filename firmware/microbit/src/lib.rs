#![no_std]
//! Not yet run on hardware: these programs run in QEMU. `docs/embassy.md` lists what to check.
//!
//! The common part of the programs for the micro:bit: the step timer, the pins, and a line for
//! output.
//!
//! | program | content |
//! | --- | --- |
//! | `bin/embassy.rs` | Embassy: moves that are awaited, joined and raced |
//! | `bin/rtic.rs` | RTIC 2: the program owns the step interrupt |
//! | `bin/bare.rs` | a main loop that sleeps |
//!
//! X steps at P15 (P0.21), Y at P14; DIR is P2 (P0.1) and P1. `cargo xtask test --only qemu` runs
//! them, and compares their edges with the virtual board's.

use core::fmt::{Arguments, Write};

use panic_halt as _;
use stepwright::{EngineHandle, SharedEngine};
pub use stepwright_nrf51::board::BOARD;
use stepwright_nrf51::pins::StepPins;
use stepwright_nrf51::timer::{StepInterrupt, Timer};
use stepwright_nrf51::uart::Uart;

/// The engine in a static.
pub type Engine = SharedEngine<Timer, StepPins, StepInterrupt, 3>;
/// The main loop's handle to the engine.
pub type Handle = EngineHandle<Timer, StepPins, StepInterrupt, 3, 8>;

/// The started step timer, and the pins, low.
///
/// # Safety
/// Called once.
pub unsafe fn start() -> (Timer, StepPins) {
    // SAFETY: the caller's promise.
    unsafe { (Timer::start(), StepPins::new()) }
}

/// Sends a line on the USB's serial port, 115200 baud.
#[macro_export]
macro_rules! say {
    ($($words:tt)*) => { $crate::send(format_args!($($words)*)) };
}

/// Sends a line.
#[doc(hidden)]
pub fn send(words: Arguments<'_>) {
    // SAFETY: the programs have no other line, and send one line at a time.
    let mut line = unsafe { Uart::to_talk() };
    // Writing to the line can't fail.
    let _ = line.write_fmt(words);
    let _ = line.write_char('\r');
}
