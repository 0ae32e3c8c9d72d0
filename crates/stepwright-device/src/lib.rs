#![no_std]
#![forbid(unsafe_code)]
//! What a stepper controller does besides stepping.
//!
//! [`Device`] joins the serial line's slave to the motors and has the supervisor
//! that goes with them: it switches the drivers on and off, obeys the limit
//! switches, brakes when the host falls silent, refuses what its settings
//! forbid, and keeps the settings when the power goes off, where the board has an
//! EEPROM for them.
//!
//! ```text
//!   bytes ─► Slave ─► switches ► OrderedMotors ─► queues ─► Engine (step interrupt)
//!                       ▲             ▲
//!            Settings ──┴─ Supervisor ┤
//!               ▲            ▲        └ stop, kill
//!             Store        BoardIo: millis, switches, enable, EEPROM
//! ```
//!
//! It does no I/O. A board lends it a [`BoardIo`]: eight methods for pins and
//! time, three for what it knows of its last reset, and, as a [`Memory`], three for
//! the bytes of its EEPROM. So the virtual board and a chip have the same
//! supervision, from the same code.

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
pub use reset::{Mark, Reset};
pub use store::Store;
pub use stream::{StreamDevice, StreamIo, StreamProgram, Streamless};
