//! All tests of this crate in one program, which is built and linked once.

mod joined;
mod numbers;
