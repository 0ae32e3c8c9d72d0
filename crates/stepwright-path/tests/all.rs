//! All tests of this crate in one program, which is built and linked once.

mod jobs;
mod judge;
mod optimal;

mod arc_fit;
mod changes;
mod cycles;
mod holds;
mod judging;
mod legs;
mod optimum;
mod orders;
mod paths;
mod random_routes;
mod rough;
mod routes;
mod smooth_routes;
mod speed;
mod unshared;
mod waits;
