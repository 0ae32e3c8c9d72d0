//! The host library for a web page, or for Node: [`Keeper`](stepwright_keeper::Keeper) and the conversation
//! below it as WebAssembly. Orders, homing, staying in step and the lease are those of all other hosts.
//!
//! ```text
//!   page ─► wire ◄─ bytes ─► door ─► Host: pipe, jobs, clock
//!     ▲                       │        │ polled after each event
//!     └── messages, JSON ◄────┘        └► keep: meet ─► turn, turn … ─► lost ─► meet again
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | [`door`] | the functions that a page calls |
//! | [`host`] | the state between two calls, and the future that the calls run |
//! | [`page_desk`] | the link between the page and the keeper |
//!
//! The virtual board is another module (`stepwright-wasm-board`): the linker proves it free of panics, which it
//! can't for text, JSON and allocation. A panic here ends the module with a trap; the board in its worker, or
//! at its port, then brakes when its lease ends.

#![warn(missing_docs)]

pub mod door;
pub mod host;
pub mod page_desk;

pub use host::{Event, WasmHost};
pub use page_desk::PageDesk;
