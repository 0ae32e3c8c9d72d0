#![cfg_attr(target_os = "none", no_std)]
//! Not yet run on hardware: this was only built. `README.md` lists what to check.
//!
//! Stepwright on a SAM3X8E (Cortex-M3, 84 MHz): the Arduino Due, whose line is the programming port.
//!
//! | file | content |
//! | --- | --- |
//! | `board.rs` | the board as data |
//! | `chip.rs` | clocks, peripherals, priorities |
//! | `timer.rs` | the first channel of timer 0 as the step timer, and its interrupt held off |
//! | `pins.rs` | STEP and DIR, and the pins around the motors |
//! | `uart.rs` | the serial line |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/port_test.rs` | tests the contract of the timer |
//!
//! Registers are used by address, because the crate `atsam3x8e` is under the EUPL. `cargo xtask
//! firmware sam3x` builds it.

pub mod board;

#[cfg(target_os = "none")]
pub mod chip;
#[cfg(target_os = "none")]
pub mod pins;
#[cfg(target_os = "none")]
pub mod timer;
#[cfg(target_os = "none")]
pub mod uart;
#[cfg(target_os = "none")]
mod vectors;

#[cfg(target_os = "none")]
stepwright_controller::never_panics!();
