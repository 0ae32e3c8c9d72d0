//! All tests of this crate in one program, which is built and linked once.

mod changes;
mod faults;
mod laws;
mod line;
mod motion;
mod published;
