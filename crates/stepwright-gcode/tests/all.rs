//! All tests of this crate, but for rs274.rs, in one program, which is built and linked once.

mod common;

mod arcs;
mod errors;
mod fuzz;
mod lines;
mod modes;
mod properties;
