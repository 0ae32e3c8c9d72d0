#![no_std]
//! Players that make steps by themselves: the PIO of an RP2040, a ring that DMA empties, an RMT.
//!
//! ```text
//!   Steppers ─► queue ─► SinkEngine ─► Grouper ─► Player ─► STEP, DIR
//!               entries                groups     a FIFO of the chip
//!                          ▲                        │
//!                          └──── serve ◄────────────┘ its interrupt: a group has begun
//! ```
//!
//! A [`Player`] plays groups of equal steps, with no help of the processor. [`SinkEngine`] makes
//! groups of what the planner queues, and is a [`Control`](stepwright::Control): `Steppers` and
//! `OrderedMotors` drive it as they drive an [`Engine`](stepwright::Engine). [`SharedSink`] is the
//! place for both in a program with an interrupt.
//!
//! | file | what |
//! | --- | --- |
//! | `group.rs` | entries become groups, with the rounding carried |
//! | `player.rs` | what a player guarantees |
//! | `engine.rs`, `track.rs` | the engine over a player, and an axis of it |
//! | `shared.rs` | engine and queues in a static |
//! | `model.rs` | a player on a PC, in simulated time |
//! | `check.rs` | does a player keep its contract? |

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
