#![cfg_attr(target_os = "none", no_std)]
//! There is no hardware: this runs only on QEMU's board, so nothing can be checked with an
//! oscilloscope.
//!
//! Stepwright on RISC-V: the board `virt` of QEMU, with the timer that every RISC-V has (`mtime`,
//! `mtimecmp`) and a line that most PCs have (16550). No such board can be bought: it is the model
//! for real RISC-V chips.
//!
//! | file | content |
//! | --- | --- |
//! | `board.rs` | the board as data; also for a host |
//! | `timer.rs` | `mtime` as the step timer, and its interrupt held off |
//! | `../qemu/chip/pins.rs` | a port of memory: STEP, DIR, and the enable pin |
//! | `uart.rs` | the serial line |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/stream.rs` | the player of a host's stream |
//! | `src/bin/laws.rs`, `cycles.rs` | Austin's laws and motor cycles over the line |
//! | `src/bin/planned.rs` | planned motors in your own program: lines and moves |
//! | `src/bin/port_test.rs` | tests the contract of the timer |
//! | `src/bin/urgent.rs` | measures how long a more urgent interrupt waits |
//!
//! `cargo xtask firmware virt` builds it, `cargo xtask test --only qemu` runs it.

pub mod board;

#[cfg(target_os = "none")]
#[path = "../../qemu/chip/pins.rs"]
pub mod pins;
#[cfg(target_os = "none")]
pub mod timer;
#[cfg(target_os = "none")]
pub mod uart;

#[cfg(target_os = "none")]
stepwright_controller::never_panics!();
