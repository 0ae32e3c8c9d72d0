#![no_std]
//! Real-time motion for stepper motors.

mod fixed;
pub mod profile;
pub mod run;
pub mod units;

pub use run::Run;
pub use units::{Accel, Geometry, OutOfRange, Rate, Speed, Ticks, Turn};
