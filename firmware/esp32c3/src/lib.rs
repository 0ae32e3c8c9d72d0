#![cfg_attr(target_os = "none", no_std)]
//! Not yet run on hardware: this was only built. `README.md` lists what to check.
//!
//! Stepwright on an ESP32-C3 (RISC-V, 160 MHz), with Espressif's `esp-hal`. Its line is UART 0,
//! which a DevKit connects to its USB socket.
//!
//! | file | content |
//! | --- | --- |
//! | `board.rs` | the board as data |
//! | `timer.rs` | SYSTIMER as the step timer, and its interrupt held off |
//! | `pins.rs` | STEP and DIR, and the pins around the motors |
//! | `uart.rs` | the serial line |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/port_test.rs` | tests the contract of the timer |
//!
//! `esp-hal` can panic, so a program here can too: it halts then. `cargo xtask firmware esp32c3`
//! builds it.

pub mod board;

#[cfg(target_os = "none")]
pub mod pins;
#[cfg(target_os = "none")]
pub mod timer;
#[cfg(target_os = "none")]
pub mod uart;
