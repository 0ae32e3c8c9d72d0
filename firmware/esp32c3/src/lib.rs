#![cfg_attr(target_os = "none", no_std)]
//! No hardware was seen: this was built, and never run on a chip. See `README.md` for what to check.
//!
//! Stepwright on an ESP32-C3 (RISC-V, 160 MHz), over Espressif's `esp-hal`. Its line is UART 0, which a
//! DevKit has at its USB socket.
//!
//! | file | what |
//! | --- | --- |
//! | `board.rs` | the board as data |
//! | `timer.rs` | SYSTIMER as the step timer, and its interrupt held off |
//! | `pins.rs` | STEP and DIR, and the pins around the motors |
//! | `uart.rs` | the serial line |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/port_test.rs` | does the timer keep the contract? |
//!
//! `esp-hal` can panic, so a program here may: it stands still then. `cargo xtask firmware esp32c3` builds
//! it.

pub mod board;

#[cfg(target_os = "none")]
pub mod pins;
#[cfg(target_os = "none")]
pub mod timer;
#[cfg(target_os = "none")]
pub mod uart;
