//! All tests of this crate in one program, which is built and linked once.

mod common;
#[path = "common/judge.rs"]
mod judge;
#[path = "common/noise.rs"]
mod noise;

mod axes;
mod extensions;
mod fuzz;
mod loopback;
mod nano_slave;
mod on_the_way;
mod safety;
mod settings;
mod starting;
mod sums;
