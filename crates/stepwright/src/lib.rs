#![no_std]
//! Real-time motion for stepper motors.
//!
//! Begin with [`Steppers`]: motors with limits and positions, moved in the background by a step
//! interrupt.
//!
//! - `SharedEngine` (feature `critical-section`) is the engine of such an interrupt on any chip;
//!   [`timer::StepTimer`] and [`drive::Drive`] are what a chip implements.
//! - [`OrderedMotors`] take orders that have their own limits, as on a serial line.
//! - [`profile`] computes the delays of a travel exactly, on a host; [`compress`] makes runs of
//!   them.
//! - [`engine`], [`entry`] and [`queue`] play runs: deadlines, pulses, directions.

mod board;
mod by_news;
mod clamp;
pub mod compress;
mod control;
pub mod drive;
pub mod engine;
pub mod entry;
pub mod fixed;
mod format;
mod group;
mod late;
mod line;
mod motor;
mod num;
mod order;
mod ordered;
mod planner;
pub mod profile;
pub mod queue;
pub mod run;
#[cfg(feature = "critical-section")]
mod shared;
mod steppers;
pub mod timer;
pub mod units;
mod wide;

pub use board::{Board, Cost, StepTicks};
pub use by_news::ByNews;
pub use control::Control;
pub use engine::{Engine, Playing, Report, Timing};
pub use group::PlannedBoard;
pub use late::late_after;
#[cfg(feature = "external-numbers")]
pub use num::layout as number_layout;
pub use order::{Change, Order, Refusal, Travel};
pub use ordered::OrderedMotors;
pub use run::Run;
#[cfg(feature = "critical-section")]
pub use shared::{EngineHandle, HoldOff, SharedEngine};
pub use steppers::{Axis, AxisLimits, AxisSet, MoveError, Steppers};
pub use units::{Accel, Geometry, Jerk, OutOfRange, Rate, Speed, Ticks, Turn};
