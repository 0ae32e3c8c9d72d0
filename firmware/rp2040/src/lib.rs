#![cfg_attr(target_os = "none", no_std)]
//! No hardware was seen yet: it runs in rp2040js, processor and PIO in lock-step. What to check:
//! `docs/pico.md`.
//!
//! Stepwright on an RP2040 (Cortex-M0+, 125 MHz): the Raspberry Pi Pico. Its PIO makes the steps, a
//! state machine an axis; an interrupt a group of steps keeps its FIFO filled.
//!
//! | file | what |
//! | --- | --- |
//! | `board.rs` | the board as data; for a host too |
//! | `program.rs` | the state machines' program; for a host too |
//! | `pio.rs` | the player over four state machines, and its interrupt held off |
//! | `divided.rs` | a player whose ticks are several of another's; for a host too |
//! | `chip.rs` | clocks, resets, the time, functions of pins |
//! | `pins.rs` | the pins around the motors, the watchdog |
//! | `lines.rs` | the serial line: over USB while that is open, over the UART else |
//! | `uart.rs`, `usb.rs` | the two; `usb_answers.rs`, for a host too, has what a USB device says of itself |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/stream.rs` | streamed runs |
//! | `capture.rs`, `watcher.rs` | STEP captured by the other PIO; its program, for a host too |
//! | `src/bin/selftest.rs` | plays seeded orders, captures its own STEP, says a line |
//! | `src/bin/trial.rs` | four axes, ordered about by a test |
//!
//! `cargo xtask firmware rp2040` builds it, `cargo xtask test --only pico` tries it.

pub mod board;
pub mod divided;
pub mod program;
pub mod usb_answers;
pub mod watcher;

#[cfg(target_os = "none")]
pub mod capture;
#[cfg(target_os = "none")]
pub mod chip;
#[cfg(target_os = "none")]
pub mod lines;
#[cfg(target_os = "none")]
pub mod pins;
#[cfg(target_os = "none")]
pub mod pio;
#[cfg(target_os = "none")]
pub mod uart;
#[cfg(target_os = "none")]
pub mod usb;
#[cfg(target_os = "none")]
mod vectors;

#[cfg(target_os = "none")]
stepwright_controller::never_panics!();
