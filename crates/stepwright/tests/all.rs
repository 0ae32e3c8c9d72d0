//! All tests of this crate in one program, which is built and linked once.

mod bounds;
mod by_news;
mod early;
mod engine;
mod exact;
mod group;
mod line;
mod pieces;
mod pulses;
mod reaction;
mod s_curve;
mod s_curve_changes;
mod stop;
