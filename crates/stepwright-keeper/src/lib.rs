//! Keeps a stepper board for pages and programs: what may be asked of it, how that is carried out,
//! and what is told of it. It does no I/O, and knows neither HTTP nor a browser: `stepwright serve`
//! runs it on a thread, a page without a server as WebAssembly.
//!
//! ```text
//!   request, JSON ─► Wish ─► Job ─► Keeper ─► Conversation ─► Pipe ─► bytes
//!   state, plans, notes ◄─ KeeperDesk ◄─┘
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | [`request`], [`asked`] | what may be asked, checked; the same by its address |
//! | [`decline`] | refusals: what, what is allowed, what to do |
//! | [`report`] | what is told |
//! | [`explain`] | what the lines of the conversation mean, and who says them ([`tap`]) |
//! | [`scope`] | the pins of the last seconds, as VCD, CSV and MCAP ([`mcap`]) |
//! | [`jobs`] | what waits to be carried out |
//! | [`keeper`] | looks at the axes, carries out jobs, meets a lost board again |
//! | `orders`, `homing`, `waits` | begins orders, homes, answers when an order has ended |
//! | `sight`, `sheet` | what is known of an axis, and of the board |
//! | `forecast`, [`pulses`] | where an order will take an axis, and which pulses it has |

#![warn(missing_docs)]
#![deny(unsafe_code)]

pub mod asked;
pub mod decline;
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
