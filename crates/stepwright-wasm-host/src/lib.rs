//! The host library for a web page, or for Node: [`Keeper`](stepwright_keeper::Keeper) and the
//! conversation below it as WebAssembly. An order's life, homing, staying in step and the lease are
//! those of every other host.
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
//! | [`host`] | what is known between two calls, and the future that they carry on |
//! | [`page_desk`] | between the page and the keeper |
//!
//! The virtual board is another module (`stepwright-wasm-board`): it is proven free of panics by the
//! linker, which text, JSON and allocation are not. A panic here ends the module with a trap; the
//! board in its worker, or behind its port, brakes when its lease ends.

#![warn(missing_docs)]

pub mod door;
pub mod host;
pub mod page_desk;

pub use host::{Event, WasmHost};
pub use page_desk::PageDesk;
