//! All tests of this crate in one program, which is built and linked once.

mod common;

mod arcs;
mod errors;
mod fuzz;
mod lines;
mod modes;
mod properties;
mod rs274;
