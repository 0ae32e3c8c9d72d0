//! All tests of this crate in one program, which is built and linked once.

mod common;

mod laser;
mod motion;
mod noise;
mod protocol;
mod stops;
