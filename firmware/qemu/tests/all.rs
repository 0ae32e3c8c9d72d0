//! All tests of this crate except pico.rs in one program, which is built and linked once.

#[path = "../../../crates/stepwright-feeder/tests/common/mod.rs"]
mod feed;
#[path = "../chip/planned.rs"]
mod planned;
mod streamed;

mod conversation;
mod edges;
mod examples;
mod port_test;
mod programs;
mod selftest;
mod stream;
mod urgent;
