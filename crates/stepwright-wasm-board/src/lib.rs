#![cfg_attr(target_family = "wasm", no_std)]
//! A virtual board for a web page, or for Node.
//!
//! | module | what |
//! | --- | --- |
//! | [`machine`] | the virtual board with its limit switch, and the edges of its pins |
//! | [`tape`] | the last edges, and where the shafts are |
//! | [`door`] | the functions that a page calls |
//!
//! Whoever talks to it is a host: the page's is `stepwright-wasm-host`. That is another module,
//! because it has text, JSON and allocation, which the linker can't prove free of panics.
//!
//! As WebAssembly it imports nothing. Its panic handler is a function that would have to be
//! imported, so a build without imports holds no code that panics: `cargo xtask wasm` checks it.

pub mod door;
pub mod machine;
pub mod tape;

pub use machine::VirtualMachine;
pub use tape::Tape;
