//! Drives a Stepwright board from a PC. [`Board`] has the same words here as [`Steppers`](stepwright::Steppers)
//! has on a chip.
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
//! The types of speeds and of the protocol are in two crates that are re-exported here:
//!
//! ```
//! use std::time::Duration;
//! use stepwright_host::stepwright::{Accel, Speed};
//! use stepwright_host::{Board, Direction, MotionLimits};
//! # fn main() -> Result<(), stepwright_host::Error> {
//! let mut board = Board::virtual_uno(true)?;
//! let slow = MotionLimits::new(Speed::of::<200>(), Accel::of::<1_000>());
//! println!("{}", board.axis(1)?.run(Direction::Backward, &slow, Duration::from_secs(2))?);
//! # Ok(())
//! # }
//! ```
//!
//! ```text
//!   Board ──► Session ───┐                      ┌──► Link: a port, a socket, a board in the process
//!   blocks    waits      ├► Conversation ► Pipe ┤
//!   AsyncBoard ──────────┘  a state machine     └──► a stream of tokio's
//!   awaits                  without I/O
//! ```
//!
//! - [`Board`] moves axes and returns an [`Outcome`]. `AsyncBoard` (feature `tokio`) has the same calls as
//!   futures.
//! - [`Session`] waits for each line of a [`Conversation`].
//! - [`programs`] has boards with Austin's laws, the timed driver or motor cycles instead of the controller.
//! - [`Conversation`] says lines, and handles missing answers. It does no I/O: the caller feeds its [`Pipe`].
//!
//! A program that holds a port lets others ask the board and change travels through it (feature `serial`, on
//! Unix), as the command `stepwright` does.

#![warn(missing_docs)]
#![deny(unsafe_code)]

#[cfg(feature = "tokio")]
mod async_board;
mod board;
mod calls;
pub mod change;
pub mod conversation;
pub mod course;
pub mod guests;
pub mod home;
pub mod homing;
pub mod line;
pub mod link;
pub mod motion;
mod outcome;
mod pipe;
pub mod programs;
mod rows;
mod session;
pub mod settings;

// Runs the example of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

#[cfg(feature = "tokio")]
pub use async_board::{AsyncAxis, AsyncBoard};
pub use board::{Axis, Board};
pub use conversation::{Conversation, LinkError, Played};
pub use motion::{Action, Sight};
pub use outcome::{Error, MotionLimits, Outcome};
pub use pipe::Pipe;
pub use session::{Activity, Interrupt, Session};
/// Speeds, accelerations and jerks, as in [`MotionLimits`].
pub use stepwright;
/// Directions, settings and reasons: the words of the protocol.
pub use stepwright_protocol;
pub use stepwright_protocol::Direction;
