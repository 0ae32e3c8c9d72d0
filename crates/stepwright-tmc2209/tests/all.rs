//! All tests of this crate in one program, which is built and linked once.

#[path = "../../stepwright-embassy/tests/bench/mod.rs"]
mod bench;
mod model;

mod homing;
mod line;
