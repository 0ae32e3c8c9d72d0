//! All tests of this crate in one program, which is built and linked once.

#[path = "common/bends.rs"]
mod bends;
#[path = "common/conversation.rs"]
mod conversation;
#[path = "common/curve.rs"]
mod curve;
#[path = "common/edges.rs"]
mod edges;
#[path = "common/legs.rs"]
mod legs;
#[path = "common/story.rs"]
mod story;

mod bent;
mod board;
mod change;
mod coils;
mod contacts;
mod duties;
mod homing;
mod line;
mod motion;
mod next_order;
mod ports;
mod program_noise;
mod pulse;
mod reset;
mod rest;
mod safety;
mod smooth;
mod soft_limits;
mod steppers;
mod stop;
mod timed;
mod unmeasured;
