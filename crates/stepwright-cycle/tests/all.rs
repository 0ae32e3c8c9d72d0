//! All tests of this crate in one program, which is built and linked once.

#[path = "common/rig.rs"]
mod rig;

mod brake;
mod calibrate;
mod cycle;
mod faults;
mod grid;
mod random;
mod remote;
