#![cfg_attr(target_os = "none", no_std)]
//! Not yet run on hardware: it runs in rp2040js, processor and PIO in lock-step. `docs/pico.md`
//! lists what to check.
//!
//! Stepwright on an RP2040 (Cortex-M0+, 125 MHz): the Raspberry Pi Pico. Its PIO makes the steps,
//! with one state machine for each axis; an interrupt for each group of steps keeps the machine's
//! FIFO filled.
//!
//! | file | content |
//! | --- | --- |
//! | `board.rs` | the board as data; also for a host |
//! | `program.rs` | the state machines' program; also for a host |
//! | `pio.rs` | the player over four state machines, and its interrupt held off |
//! | `divided.rs` | a player whose tick is several ticks of another; also for a host |
//! | `chip.rs` | clocks, resets, the time, functions of pins |
//! | `pins.rs` | the pins around the motors, the watchdog |
//! | `lines.rs` | the serial line: over USB while that port is open, otherwise over the UART |
//! | `uart.rs`, `usb.rs` | the two lines; `usb_answers.rs`, also for a host, has the USB descriptors |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/stream.rs` | the player of a host's stream |
//! | `capture.rs`, `watcher.rs` | STEP captured by the other PIO; its program, also for a host |
//! | `src/bin/selftest.rs` | plays seeded orders, captures its own STEP, sends a line |
//! | `src/bin/trial.rs` | four axes, controlled by a test |
//!
//! `cargo xtask firmware rp2040` builds it, `cargo xtask test --only pico` tests it.

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

#[cfg(all(target_os = "none", feature = "program"))]
stepwright_controller::never_panics!();
