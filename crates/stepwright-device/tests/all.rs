//! All tests of this crate in one program, which is built and linked once.

mod common;

mod interleaved;
mod line;
mod main_loop;
mod store;
mod stream;
mod supervisor;
