//! All tests of this crate in one program, which is built and linked once.

mod brake;
mod fit;
mod frames;
mod records;
