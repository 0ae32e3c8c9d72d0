//! All tests of this crate in one program, which is built and linked once.

mod bench;

mod drops;
mod ends;
mod moves;
mod random;
