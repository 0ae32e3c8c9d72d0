//! Board support of Stepwright for Arduino Uno, Nano and Mega: ATmega328P and ATmega2560, 16 MHz.
//!
//! A program of your own is one function; the step interrupts move the motors while it runs:
//!
//! ```ignore
//! #![no_std]
//! #![no_main]
//! #![feature(asm_experimental_arch)]
//!
//! use stepwright::{Axis, MoveError};
//! use stepwright_avr::steppers::Steppers;
//!
//! stepwright_avr::steppers!(main);
//!
//! fn main(motors: &mut Steppers) -> Result<(), MoveError> {
//!     motors.move_to(Axis::X, 8_000)?; // returns at once
//!     while motors.is_moving(Axis::X) {
//!         motors.poll(); // plans ahead; your own work comes here
//!     }
//!     Ok(())
//! }
//! ```
//!
//! Its `Cargo.toml` depends on this crate with the feature `uno` (also for a Nano) or `mega`, and
//! on `avr-device` with `rt`, because the macros of this crate use it. It is built like any program
//! for an AVR: a compiler with `rust-src`, `-Zbuild-std=core`, `--target avr-none`, `-C
//! target-cpu=atmega328p`, optimised, with `panic = "abort"`; the README has all flags, and a check
//! that a program for a Mega needs. A program that can panic does not
//! link: the panic handler calls a function that does not exist. Without the default feature
//! `panic-handler` the program needs a handler of its own.
//!
//! # The way of the data
//!
//! ```text
//!   Steppers ─► Queue ─► step: an interrupt an axis, in assembly ─► STEP, DIR   (planned moves)
//!   Cycle ─────────────► cycle: one compiled interrupt ───────────► STEP, DIR   (motor cycles)
//!   Steppers ─► Queue ─► planned: one compiled interrupt ─────────► any drive
//!   Cycle ─────────────► cycle_drives: likewise ──────────────────► any drive for each motor
//!   law ───────────────► asked: one compiled interrupt ───────────► any drive
//!   Driver ─► Pace ────► timed: one compiled interrupt a timer ───► windings    (timed driver)
//!
//!   bytes ─► serial ─► main loop of stepwright-device ─► panel: enable, switches, EEPROM
//! ```
//!
//! A program uses only one of the first five ways, because each needs the step timer for itself.
//!
//! | file | content |
//! | --- | --- |
//! | [`steppers`] | motors for your own program |
//! | [`board`] | the chip, its pins, and the cost of its steps |
//! | [`step`] | the step interrupts that play queues, and the foreground's handle to them |
//! | `numbers` | the planner's numbers in assembly |
//! | [`cycle`], [`cycles`], [`timer`] | motor cycles on the step timer; on any pins, ordered over the line |
//! | [`planned`], [`cycle_drives`] | planned moves, and motor cycles, on any drive |
//! | [`drives`] | drives on pins that are chosen while the program runs |
//! | [`asked`] | any law on any drive, computed in the step interrupt |
//! | `law` | laws that are computed in the main loop, and the cost of a step of each (Uno) |
//! | `laws` | Austin's laws, ordered over the line |
//! | `stream` | the player of a host's stream |
//! | [`timed`] | the timed driver |
//! | [`laps`], [`guarded`] | a far time on a counter of 16 bits; a motor that an interrupt owns |
//! | [`serial`] | the serial line, by interrupts |
//! | [`console`] | the serial line and a clock, without interrupts |
//! | [`panel`], [`eeprom`], [`clock`], [`watchdog`], [`reset`] | the board's side of the device |
//! | [`lamp`] | the lamp at D13 |
//! | [`slot`], `in_flash`, `memory` | statics, constants in flash, copying in few bytes |
//! | [`interrupt`] | the declaration of handlers, and the cycles that a simulator leaves out |
//!
//! # Memory and time
//!
//! `first-move` takes 22 KB of flash and 1.2 KB of RAM on an Uno, without the stack. A step is 70
//! cycles of interrupt; a piece of planning, in the main loop, 3,200 cycles at most
//! (`bench/avr.json` in the repository).
#![no_std]
#![feature(asm_experimental_arch)]

#[cfg(feature = "uno")]
pub use avr_device::atmega328p as chip;
#[cfg(feature = "mega")]
pub use avr_device::atmega2560 as chip;

#[cfg(any(all(feature = "uno", feature = "mega"), not(any(feature = "uno", feature = "mega"))))]
compile_error!("choose a chip: the feature `uno` (for a Nano too) or `mega`");

#[cfg(all(feature = "uno", any(feature = "timer3", feature = "timer4", feature = "timer5")))]
compile_error!("the ATmega328P has no timer of 16 bits but timer 1");

pub mod asked;
pub mod board;
pub mod clock;
pub mod console;
pub mod cycle;
pub mod cycle_drives;
pub mod cycles;
pub mod drives;
pub mod eeprom;
pub mod guarded;
#[doc(hidden)]
pub mod in_flash;
pub mod interrupt;
pub mod lamp;
pub mod laps;
#[cfg(feature = "uno")]
pub mod law;
#[cfg(any(feature = "constant", feature = "transitions", feature = "power"))]
pub mod laws;
mod memory;
mod numbers;
pub mod panel;
#[cfg(feature = "panic-handler")]
mod panic;
pub mod planned;
pub mod reset;
pub mod serial;
pub mod slot;
pub mod step;
pub mod steppers;
#[cfg(feature = "stream")]
pub mod stream;
pub mod timed;
pub mod timer;
pub mod watchdog;
