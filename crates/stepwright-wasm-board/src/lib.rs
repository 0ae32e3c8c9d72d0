#![cfg_attr(target_family = "wasm", no_std)]
//! A virtual board for a web page, and the host's half of the line to any board.
//!
//! ```text
//!   page ─► host ─► bytes ──┬──► serial port, of a board with motors
//!     ▲       ▲             └──► worker ─► board: the same engine, planner and slave
//!     └ words ┴── bytes ◄───┴────◄───┘                    on simulated pins
//! ```
//!
//! | module | what |
//! | --- | --- |
//! | [`machine`] | the virtual board with its limit switch, and the edges of its pins |
//! | [`tape`] | the last edges, and where the shafts are |
//! | [`host`] | lines that are said, answers that are understood |
//! | [`script`] | the numbers of an order, and its lines |
//! | [`words`] | what things are called, and what they mean |
//! | [`door`] | the functions that a page calls |
//!
//! As WebAssembly it imports nothing. Its panic handler is a function that would have to be
//! imported, so a build without imports holds no code that panics: `cargo xtask wasm` checks it.

pub mod door;
pub mod host;
pub mod machine;
pub mod script;
pub mod tape;
pub mod words;

pub use host::{Heard, HostHalf};
pub use machine::VirtualMachine;
pub use script::{OrderField, OrderRange};
pub use tape::Tape;
