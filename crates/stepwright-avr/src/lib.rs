//! Stepwright on a 16 MHz AVR: board support for Uno, Nano and Mega.
//!
//! | file | what |
//! | --- | --- |
//! | `board` | which chip it is, its pins, what its steps cost |
//! | `timer` | the step timer |
//! | `step` | the step interrupts that play queues, one an axis, and the foreground's hold on them |
//! | `cycle` | likewise, with stepper_h's motor cycles in it |
//! | `serial` | the serial line, USART0 |
//! | `clock` | milliseconds, without an interrupt |
//! | `watchdog` | a reset when the main loop hangs |
//! | `reset` | what the last reset was, and what RAM kept through it |
//! | `eeprom` | bytes that outlive the power |
//! | `panel` | all of these, as the device wants them |
//! | `memory` | copying and filling, in few bytes |
//! | `numbers` | the planner's numbers in assembly |
//! | `timed` | the timed driver: a shield's motor on a timer |
//! | `console` | its serial line and clock, without interrupts |
//! | `steppers` | motors for a program of one's own |
//! | `lamp` | the lamp at D13 |
//! | `law` | what a step of a law costs |
//! | `interrupt` | how handlers are declared, and what a simulator leaves out |
//!
//! The programs of `firmware/avr` are made of it, and yours can be.
#![no_std]
#![feature(asm_experimental_arch)]

#[cfg(feature = "uno")]
pub use avr_device::atmega328p as chip;
#[cfg(feature = "mega")]
pub use avr_device::atmega2560 as chip;

#[cfg(all(feature = "uno", any(feature = "timer3", feature = "timer4", feature = "timer5")))]
compile_error!("the ATmega328P has no timer of 16 bits but timer 1");

pub mod asked;
pub mod board;
pub mod clock;
pub mod console;
pub mod cycle;
pub mod eeprom;
#[doc(hidden)]
pub mod in_flash;
pub mod interrupt;
pub mod lamp;
#[cfg(feature = "uno")]
pub mod law;
mod memory;
mod numbers;
pub mod panel;
#[cfg(feature = "panic-handler")]
mod panic;
pub mod reset;
pub mod serial;
pub mod slot;
pub mod step;
pub mod steppers;
pub mod timed;
pub mod timer;
pub mod watchdog;
