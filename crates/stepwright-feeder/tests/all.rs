//! All tests of this crate in one program, which is built and linked once.

mod common;

mod cut;
mod ends;
mod feeder;
mod grbl;
mod laser;
mod silence;
