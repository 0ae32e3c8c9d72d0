#![cfg_attr(target_os = "none", no_std)]
//! No hardware was seen: QEMU's board is all there is, and nothing can be checked with an oscilloscope.
//!
//! Stepwright on RISC-V: the board `virt` of QEMU, with the timer that every RISC-V has (`mtime`,
//! `mtimecmp`) and a line that most PCs have (16550). No such board can be bought: it is the model for
//! a RISC-V that can.
//!
//! | file | what |
//! | --- | --- |
//! | `board.rs` | the board as data; for a host too |
//! | `timer.rs` | `mtime` as the step timer, and its interrupt held off |
//! | `../qemu/chip/pins.rs` | a port of memory: STEP, DIR, and the enable pin |
//! | `uart.rs` | the serial line |
//! | `src/bin/controller.rs` | the serial controller |
//! | `src/bin/stream.rs` | streamed runs |
//! | `src/bin/laws.rs`, `cycles.rs` | Austin's laws and motor cycles over the line |
//! | `src/bin/planned.rs` | planned motors in a program of one's own: lines and moves |
//! | `src/bin/port_test.rs` | does the timer keep the contract? |
//! | `src/bin/urgent.rs` | how long does a more urgent interrupt wait? |
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
