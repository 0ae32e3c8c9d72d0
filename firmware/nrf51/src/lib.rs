#![cfg_attr(target_os = "none", no_std)]
//! No hardware was seen: this runs in QEMU. See `README.md` for what to check.
//!
//! Stepwright on an nRF51822 (Cortex-M0, 16 MHz): the first BBC micro:bit, and QEMU's `microbit`.
//!
//! | file | what |
//! | --- | --- |
//! | `board.rs` | the board as data; for a host too |
//! | `timer.rs` | TIMER0 as the step timer, and its interrupt held off |
//! | `pins.rs` | STEP and DIR, and the pins around the motors |
//! | `uart.rs` | the serial line |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/stream.rs` | streamed runs |
//! | `src/bin/laws.rs`, `cycles.rs` | Austin's laws and motor cycles over the line |
//! | `src/bin/awaits.rs` | moves that are awaited, and can't panic |
//! | `src/bin/planned.rs` | planned motors in a program of one's own: lines and moves |
//! | `src/bin/port_test.rs` | does the timer keep the contract? |
//! | `src/bin/urgent.rs` | how long does a more urgent interrupt wait? |
//! | `src/bin/selftest.rs` | plays seeded orders, looks at its own STEP, says a line |
//!
//! Programs with an executor, with RTIC and with a main loop of their own: `firmware/microbit`.
//! `cargo xtask firmware nrf51` builds it, `cargo xtask test --only qemu` runs it in QEMU.

pub mod board;

#[cfg(target_os = "none")]
pub mod pins;
#[cfg(target_os = "none")]
pub mod timer;
#[cfg(target_os = "none")]
pub mod uart;
#[cfg(target_os = "none")]
pub mod vectors;

#[cfg(all(target_os = "none", feature = "program"))]
stepwright_controller::never_panics!();
