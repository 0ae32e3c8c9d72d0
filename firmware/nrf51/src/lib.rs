#![cfg_attr(target_os = "none", no_std)]
//! Not yet run on hardware: this runs in QEMU. `README.md` lists what to check.
//!
//! Stepwright on an nRF51822 (Cortex-M0, 16 MHz): the first BBC micro:bit, and QEMU's `microbit`.
//!
//! | file | content |
//! | --- | --- |
//! | `board.rs` | the board as data; also for a host |
//! | `timer.rs` | TIMER0 as the step timer, and its interrupt held off |
//! | `pins.rs` | STEP and DIR, and the pins around the motors |
//! | `uart.rs` | the serial line |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/stream.rs` | the player of a host's stream |
//! | `src/bin/laws.rs`, `cycles.rs` | Austin's laws and motor cycles over the line |
//! | `src/bin/awaits.rs` | awaited moves that can't panic |
//! | `src/bin/planned.rs` | planned motors in your own program: lines and moves |
//! | `src/bin/port_test.rs` | tests the contract of the timer |
//! | `src/bin/urgent.rs` | measures how long a more urgent interrupt waits |
//! | `src/bin/selftest.rs` | plays seeded orders, reads back its own STEP, sends a line |
//!
//! Programs with an executor, with RTIC and with their own main loop: `firmware/microbit`. `cargo
//! xtask firmware nrf51` builds it, `cargo xtask test --only qemu` runs it in QEMU.

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
