//! Keeps a stepper board for pages and programs: which requests there are, how they are carried out, and what
//! is reported. The crate does no I/O, and knows neither HTTP nor a browser: `stepwright serve` runs it on a
//! thread, a page without a server runs it as WebAssembly.
//!
//! ```text
//!   request, JSON ─► Wish ─► Job ─► Keeper ─► Conversation ─► Pipe ─► bytes
//!   state, plans, notes ◄─ KeeperDesk ◄─┘
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | [`request`], [`asked`] | requests, checked; the same by their address |
//! | [`decline`] | refusals: the reason, what is allowed, the remedy |
//! | [`report`], [`drawing`] | reports; the drawing of a file |
//! | [`explain`] | the meaning of the conversation's lines, which [`tap`] listens to |
//! | [`scope`] | the pins of the last seconds, as VCD, CSV and MCAP ([`mcap`]) |
//! | [`jobs`] | jobs that wait to be carried out |
//! | [`keeper`] | looks at the axes, carries out jobs, meets a lost board again |
//! | `orders`, `homing`, `waits` | begin orders, home, answer when an order has ended |
//! | `sight`, `sheet` | the known state of an axis, and the board's description |
//! | `forecast`, [`pulses`] | the expected course of an order, and its pulses |

#![warn(missing_docs)]
#![deny(unsafe_code)]

pub mod asked;
pub mod decline;
pub mod drawing;
pub mod explain;
mod forecast;
mod homing;
pub mod jobs;
pub mod keeper;
pub mod mcap;
mod orders;
pub mod pulses;
mod refused;
pub mod report;
pub mod request;
pub mod scope;
mod sheet;
mod sight;
pub mod tap;
mod waits;

pub use decline::Declined;
pub use jobs::{Job, JobQueue};
pub use keeper::{Keeper, KeeperDesk, KeptBoard};
pub use request::{Hand, Wish};
