#![no_std]
#![forbid(unsafe_code)]
//! The parts of a stepper controller other than stepping.
//!
//! [`Device`] joins the serial line's slave to the motors, and contains their supervisor. The
//! supervisor switches the drivers on and off, obeys the limit switches, brakes when the host falls
//! silent, refuses orders that the settings forbid, and keeps the settings through a loss of power
//! if the board has an EEPROM.
//!
//! ```text
//!   bytes ─► Slave ─► switches ► OrderedMotors ─► queues ─► Engine (step interrupt)
//!                       ▲             ▲
//!            Settings ──┴─ Supervisor ┤
//!               ▲            ▲        └ stop, kill
//!             Store        BoardIo: millis, switches, enable, EEPROM
//! ```
//!
//! It does no I/O. A board lends it a [`BoardIo`]: eight methods for pins and time, three about the
//! last reset, and, as a [`Memory`], three for the bytes of its EEPROM. So the virtual board and a
//! chip are supervised by the same code.

mod contacts;
mod device;
mod inputs;
mod machine;
pub mod main_loop;
mod panel;
mod program;
mod reset;
mod store;
mod stream;
mod supervisor;

pub use device::Device;
pub use panel::{BoardIo, Memory};
pub use program::ProgramDevice;
pub use reset::{Mark, Reset, ResetIo};
pub use store::Store;
pub use stream::{StreamDevice, StreamIo, StreamProgram, Streamless};
