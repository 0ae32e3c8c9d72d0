#![cfg_attr(target_os = "none", no_std)]
//! Not yet run on hardware: this was only built. `README.md` lists what to check.
//!
//! Stepwright on an STM32F411 (Cortex-M4, 96 MHz): ST's Nucleo-F411RE, whose line is the debugger's USB.
//!
//! | file | content |
//! | --- | --- |
//! | `board.rs` | the board as data |
//! | `chip.rs` | clocks, functions of pins, priorities |
//! | `timer.rs` | TIM2 as the step timer, and its interrupt held off |
//! | `pins.rs` | STEP and DIR, and the pins around the motors |
//! | `uart.rs` | the serial line |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/port_test.rs` | tests the contract of the timer |
//! | `src/bin/selftest.rs` | plays seeded orders, reads back its own STEP, sends a line |
//!
//! `cargo xtask firmware stm32f4` builds it.

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
stepwright_controller::never_panics!();
