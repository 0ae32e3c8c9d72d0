//! The rig: Stepwright's firmware on a simulated chip, cycle by cycle.
//!
//! A [`Chip`] runs the binary of a real board. The rig simulates the surroundings: it sends bytes
//! to the serial port, presses switches, cuts the power, and records every edge of the STEP, DIR
//! and ENABLE pins with its cycle. The motion of the motors is reconstructed from the edges alone
//! ([`edges`]).
//!
//! ```text
//!   lines ──► Line ──► USART0 ┌──────┐ STEP, DIR ──► Vec<Edge> ──► steps, checks
//!   answers ◄──────── USART0 │ Chip │ ENABLE    ──► changes
//!   switches ────────► pins   └──────┘ cycles in interrupts, interrupts off, RAM
//! ```
//!
//! The simulator is simavr. Where it differs from a chip the rig corrects it, or this table says
//! so:
//!
//! | simavr | chip | here |
//! | --- | --- | --- |
//! | a byte takes 11 bits | 10 | corrected |
//! | received bytes wait in 64 places | 2 and a third until the next one begins | corrected: a further byte is lost, and the flag is set |
//! | an interrupt enabled after its compare match never comes | it comes | corrected |
//! | a compare match close after the counter's overflow is missed | it comes | corrected for the timers that the firmware uses for steps |
//! | an EEPROM byte is written at once | 3.4 ms | corrected: busy for that time, and a loss of power in between spoils it |
//! | the watchdog's 128 kHz are exact | up to a tenth off | not corrected |
//! | another time-out of the running watchdog counts from the next `wdr` on | at once | not corrected: the firmware's main loop begins with a `wdr` |
//! | a timer in fast PWM, mode 15, wraps without a flag | with a flag | not corrected: that firmware runs on avr8js ([`avr8js`]) |
//! | entering an interrupt takes 0 cycles | 4 | firmware built for the bench spends them itself; otherwise edges are up to 4 cycles early |

#[cfg(feature = "judges")]
pub mod avr8js;
#[cfg(feature = "judges")]
pub mod bench;
pub mod board;
pub mod chip;
pub mod dump;
pub mod edges;
mod eeprom;
pub mod elf;
pub mod firmware;
mod line;
pub mod pair;
mod probes;
pub mod pty;
mod silicon;
pub mod stack;
#[cfg(feature = "judges")]
pub mod stress;

pub use board::Board;
pub use chip::Chip;
pub use elf::Image;
pub use pair::Pair;
pub use probes::IsrSpan;
pub use silicon::Cause;
