//! All tests of this crate except fuzz.rs in one program, which is built and linked once.

mod common;

mod axes;
mod extensions;
mod loopback;
mod nano_slave;
mod on_the_way;
mod safety;
mod settings;
mod starting;
mod sums;
