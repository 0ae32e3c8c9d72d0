#![cfg_attr(target_os = "none", no_std)]
//! Stepwright on a Cortex-M3 and a Cortex-M4: ARM's board MPS2 with the FPGA images AN385 and
//! AN386, as QEMU simulates them, with the timer and the line of ARM's own design kit (CMSDK). It
//! is the model for chips with these cores whose timers QEMU does not simulate: an STM32F4, a
//! SAM3X. It can't drive a motor.
//!
//! | file | content |
//! | --- | --- |
//! | `board.rs` | the board as data; also for a host |
//! | `timer.rs` | the dual timer as the step timer, and its interrupt held off |
//! | `../qemu/chip/pins.rs` | a port of memory: STEP, DIR, and the enable pin |
//! | `uart.rs` | the serial line |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/port_test.rs` | tests the contract of the timer |
//!
//! `cargo xtask firmware mps2` builds it, `cargo xtask test --only qemu` runs it.

pub mod board;

#[cfg(target_os = "none")]
#[path = "../../qemu/chip/pins.rs"]
pub mod pins;
#[cfg(target_os = "none")]
pub mod timer;
#[cfg(target_os = "none")]
pub mod uart;
#[cfg(target_os = "none")]
mod vectors;

#[cfg(target_os = "none")]
stepwright_controller::never_panics!();
