//! Random conversations with a board, judged from outside.
//!
//! A *story* is a board and a sequence of events: lines, noise on them, silences, switches, losses of
//! power. It is made from a seed ([`make`]), played on the virtual board or on another [`Bench`], and judged by
//! bytes and edges alone:
//!
//! ```text
//!   seed ─► story ─► player ─► bytes, switches, power ─► board
//!                       │                                  │
//!                     judge ◄──── answers, edges with time ┘
//!           grammar, settings, limits: all its own
//! ```
//!
//! The judge has its own parser ([`grammar`]), its own table of the settings, and bounds for every motion
//! from first principles ([`limits`]). It uses neither the protocol's crate nor a planner, so it can't share
//! their mistakes.

pub mod fault;
pub mod grammar;
pub mod guard;
pub mod judge;
pub mod limits;
pub mod make;
pub mod play;
pub mod reason;
pub mod run;
pub mod settings;
pub mod shrink;
mod slave;
pub mod stops;
pub mod story;
pub mod sum;
pub mod track;

pub use fault::{Fault, Rule, Rules};
pub use play::{Bench, Player, Sum, simulate};
pub use story::{Act, Board, Reset, Story};
