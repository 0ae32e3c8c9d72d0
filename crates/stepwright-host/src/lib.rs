//! Drive a Stepwright board from a PC: what [`Steppers`](stepwright::Steppers) is on a chip,
//! [`Board`] is here, with the same words.
//!
//! ```
//! use stepwright_host::{Board, MotionLimits};
//! # fn main() -> Result<(), stepwright_host::Error> {
//! let mut board = Board::virtual_uno(true)?; // or Board::open("/dev/ttyUSB0")?
//! let outcome = board.axis(1)?.move_to(4_000, &MotionLimits::default())?;
//! assert_eq!(outcome.to_string(), "reached 4000");
//! # Ok(())
//! # }
//! ```
//!
//! ```text
//!   Board ──► Session ──► Conversation ──► Pipe ──► Link: a port, a board in the process
//!   blocks    waits for     a state machine without I/O
//!             the line
//! ```
//!
//! - [`Board`] moves axes and says what became of it: [`Outcome`].
//! - [`Session`] waits for each line of a [`Conversation`].
//! - [`Conversation`] knows what to say, and what to do when no answer comes. It does no I/O:
//!   whoever has bytes and a clock can carry it on by its [`Pipe`].
//!
//! A program that holds a port lets others ask the board and change a travel through it
//! (`serial`, on Unix), as the command `stepwright` does.

#![warn(missing_docs)]
#![deny(unsafe_code)]

mod board;
pub mod change;
pub mod conversation;
pub mod guests;
pub mod home;
pub mod homing;
pub mod link;
pub mod motion;
mod pipe;
mod session;

// Its example runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use board::{Axis, Board, Error, MotionLimits, Outcome};
pub use conversation::{Conversation, LinkError, Played};
pub use pipe::Pipe;
pub use session::{Activity, Interrupt, Session};
