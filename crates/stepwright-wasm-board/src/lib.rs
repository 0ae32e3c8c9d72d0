#![cfg_attr(target_family = "wasm", no_std)]
//! A virtual board for a web page, or for Node.
//!
//! | module | what |
//! | --- | --- |
//! | [`machine`] | the virtual board with its limit switch, and the edges of its pins |
//! | [`tape`] | the last edges, and the positions of the shafts |
//! | [`door`] | the functions that a page calls |
//!
//! The board's peer is a host: for the page it is `stepwright-wasm-host`. That is another module, because its
//! text, JSON and allocation can't be proven free of panics by the linker.
//!
//! As WebAssembly it imports nothing. Its panic handler is a function that would have to be imported, so a
//! build without imports has no code that panics: `cargo xtask wasm` checks that.

pub mod door;
pub mod machine;
pub mod tape;

pub use machine::VirtualMachine;
pub use tape::Tape;
