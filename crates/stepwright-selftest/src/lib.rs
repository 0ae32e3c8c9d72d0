#![no_std]
//! The self-test of a chip: it plays seeded orders, captures STEP, and reports the result in one
//! line.
//!
//! ```text
//!   Luck ─► orders ─► OrderedMotors ─► engine ─► STEP ─► Capture ─┐
//!              └────► plan ─► when each edge should come ─────────┴─► Line ─► judge
//!                       └───► CRC-32 of the plan
//! ```
//!
//! The firmware and the command that judges its line share this crate, so they agree on orders,
//! chips and the form of the line. An error that both would share, in the ramps themselves, is left
//! to other tests, which compare the ramps with their closed forms.

mod chips;
mod judge;
mod line;
mod luck;
mod orders;
mod sum;
mod trial;

pub use chips::{CHIPS, Chip, NRF51, RP2040, STM32F411};
pub use judge::{Fault, Judgement, judge};
pub use line::{FORMAT, Line, LineError, WORD};
pub use luck::Luck;
pub use orders::{MOST_PULSES, ORDERS, STEP, groups, plan};
pub use sum::Crc32;
pub use trial::{Capture, Found, run};
