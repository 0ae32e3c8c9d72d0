#![no_std]
//! Real-time motion for stepper motors.

pub mod units;

pub use units::{Accel, Geometry, OutOfRange, Rate, Speed, Ticks, Turn};
