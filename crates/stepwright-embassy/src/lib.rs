#![no_std]
#![doc = include_str!("../README.md")]

mod axis;
mod motors;
mod news;
mod outcome;
mod waiters;

pub use axis::AsyncAxis;
pub use motors::Motors;
pub use news::News;
pub use outcome::Outcome;
