#![no_std]
#![forbid(unsafe_code)]
//! What a stepper controller does besides stepping.
//!
//! [`Device`] joins the serial line's slave to the motors and has the duties
//! that go with them: it switches the drivers on and off, obeys the limit
//! switches, brakes when the host falls silent, refuses what its settings
//! forbid, and keeps the settings when the power goes off.
//!
//! ```text
//!   bytes ─► Slave ─► switches ► Group ─► queues ─► Engine (step interrupt)
//!                       ▲         ▲
//!            Settings ──┴─ duties ┤
//!               ▲            ▲    └ brake, halt
//!             Store        Panel: millis, switches, enable, EEPROM
//! ```
//!
//! It does no I/O. A board lends it a [`Panel`]: four methods for pins and
//! time, three for the bytes of its EEPROM, and three for what it knows of its
//! last reset. So the virtual board and a
//! chip have the same duties, from the same code.

#[cfg(feature = "safety")]
mod contacts;
mod device;
mod duties;
#[cfg(feature = "safety")]
mod inputs;
mod machine;
mod panel;
mod reset;
mod store;

pub use device::Device;
pub use panel::{Memory, Panel};
pub use reset::{Mark, Reset};
pub use store::Store;
