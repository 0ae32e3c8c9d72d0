#![no_std]
#![doc = include_str!("../README.md")]

mod alarm;
mod current;
mod error;
mod faults;
mod homing;
mod line;
mod setup;

pub use alarm::brake_on_alarm;
pub use error::{DriverError, NotHomed};
pub use faults::{DriverFault, DriverFaults};
pub use homing::StallHoming;
pub use line::{DriverAddress, Tmc2209};
pub use setup::DriverSetup;
