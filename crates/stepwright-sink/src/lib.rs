#![no_std]
//! An engine for hardware that makes steps by itself: the PIO of an RP2040, a ring that DMA empties, an RMT.
//!
//! ```text
//!   Steppers ─► queue ─► SinkEngine ─► Grouper ─► Player ─► STEP, DIR
//!               entries                groups     a FIFO of the chip
//!                          ▲                        │
//!                          └──── serve ◄────────────┘ its interrupt: a group has begun
//! ```
//!
//! A [`Player`] plays groups of equal steps without the processor. [`SinkEngine`] makes these groups from the
//! entries that the planner queues. It is a [`Control`](stepwright::Control): `Steppers` and `OrderedMotors`
//! drive it as they drive an [`Engine`](stepwright::Engine). [`SharedSink`] is the place for the engine and its
//! queues in a program with an interrupt.
//!
//! | file | content |
//! | --- | --- |
//! | `group.rs` | entries become groups; rounding is carried to the next group |
//! | `player.rs` | the contract of a player |
//! | `engine.rs`, `track.rs` | the engine over a player, and its axes |
//! | `shared.rs` | engine and queues in a static |
//! | `model.rs` | a model of a player, in simulated time |
//! | `check.rs` | a test of a player against its contract |

mod check;
mod engine;
mod group;
mod model;
mod player;
mod shared;
mod track;

pub use check::{PlayerFault, PlayerPort, Tried, check};
pub use engine::SinkEngine;
pub use group::{Grouper, StepGroup};
pub use model::{ModelEdge, ModelPlayer};
pub use player::{Halted, Player};
pub use shared::{SharedSink, SinkHandle};
