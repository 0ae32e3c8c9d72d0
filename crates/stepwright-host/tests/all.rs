//! All tests of this crate in one program, which is built and linked once.

mod board;
mod guests;
mod noise;
mod pipe;
mod programs;
mod rows;
mod sent;
mod socket;
