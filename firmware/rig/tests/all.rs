//! All tests of this crate except conversation.rs in one program, which is built and linked once.

// Private to the core, which uses more of it: tests/numbers.rs.
#[allow(dead_code)]
#[path = "../../../crates/stepwright/src/clamp.rs"]
mod clamp;
mod common;
#[path = "../../../crates/stepwright-feeder/tests/common/mod.rs"]
mod feed;
#[allow(dead_code, unused_imports, clippy::all)]
#[path = "../../../crates/stepwright/src/num/mod.rs"]
mod num;

mod alone;
mod arithmetic;
mod change;
mod cycle;
mod cycle_line;
mod cycles;
mod demo;
mod doubt;
mod drives;
mod dump;
mod first_move;
mod guards;
mod homing;
mod inputs;
mod laser;
mod late;
mod laws;
mod laws_line;
mod longest;
mod motion;
mod numbers;
mod order;
mod pair;
mod port_test;
mod power;
mod pulse;
mod reset;
mod sim;
mod stack;
mod straight_line;
mod stream;
mod stress;
mod switches;
mod thousandths;
mod timed;
mod timed_line;
mod traffic;
mod triangle;
mod turns;
mod virtual_board;
mod watchdog;
