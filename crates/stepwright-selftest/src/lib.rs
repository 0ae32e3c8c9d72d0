#![no_std]
//! The self-test of a chip: seeded orders are played, STEP is captured, one line says what came of it.
//!
//! ```text
//!   Luck ─► orders ─► OrderedMotors ─► engine ─► STEP ─► Capture ─┐
//!              └────► plan ─► when each edge should come ─────────┴─► Line ─► judge
//!                       └───► CRC-32 of the plan
//! ```
//!
//! The same crate is in the firmware and in the command that judges its line: neither knows an order,
//! a chip or a form of the line that the other does not. What both could have wrong in the same way,
//! the ramps themselves, other tests hold against their closed forms.

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
