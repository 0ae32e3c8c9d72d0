//! A reader of G-code in the dialect of grbl 1.1: bytes in, canonical moves with exact positions
//! out.
//!
//! A [`Reader`] takes bytes, in pieces of any size, and returns a [`Block`] for each line: its [`Effect`]s in
//! the order of execution. A [`Move`] is a line or an arc in machine coordinates, which include the coordinate
//! systems G54 to G59, G92 and the length of the tool. Spindle, coolant and laser are signals between the
//! moves. Each takes effect at its place on the path.
//!
//! ```
//! use stepwright_gcode::{Effect, Reader};
//! let job = "G21 G90 (a square's half)\nG1 X10 F600\nY10"; // its last line has no end
//! let (mut reader, mut ends) = (Reader::default(), String::new());
//! for byte in job.bytes().chain(*b"\n") {
//!     let Some(block) = reader.push(byte) else { continue };
//!     for effect in block?.effects() {
//!         if let Effect::Move(part) = effect {
//!             ends += &format!("{}\n", part.to);
//!         }
//!     }
//! }
//! assert_eq!(ends, "X10 Y0 Z0\nX10 Y10 Z0\n");
//! # Ok::<(), stepwright_gcode::Error>(())
//! ```
//!
//! **Numbers are exact.** A [`Decimal`] has seven digits before the point and eleven after. A [`Length`] is in
//! whole picometres, up to 1 km: exact for nine digits after the point in millimetres and for eight in inches.
//! Finer digits are rounded to the nearest picometre. The centre of an arc by radius, a root, is within a
//! picometre. All checks are made in integers. No float is used, and no memory is allocated.
//!
//! # The dialect
//!
//! | group | codes |
//! | --- | --- |
//! | motion | G0 G1 G2 G3 G38.2 G38.3 G38.4 G38.5 G80 |
//! | once | G4 P, G10 L2 P, G10 L20 P, G28 G28.1 G30 G30.1 G53 G92 G92.1 |
//! | plane, units | G17 G18 G19, G20 G21 |
//! | distance, feed | G90 G91, G91.1, G93 G94 |
//! | tool | G40, G43.1 Z, G49, T |
//! | coordinate system | G54 to G59 |
//! | path | G61, G64, G64 P |
//! | program | M0 M1 M2 M30 |
//! | spindle, coolant | M3 M4 M5 S, M7 M8 M9 |
//!
//! - A word is a letter and a number, in upper or lower case. Blanks may be anywhere. Comments are in
//!   parentheses, or from `;` to the end of the line.
//! - A line that begins with `%` is ignored. A line that begins with `/` is read, unless [`Options`] ask to
//!   skip it.
//! - A line has at most 80 bytes without blanks and comments ([`Options::line_limit`]), and 65,535 in all.
//! - A byte order mark at the start of the input is ignored.
//! - A block is refused as a whole, with grbl's error number ([`Fault`]).
//! - M2 and M30 end a program: spindle and coolant go off, and G1, G17, G54, G90 and G94 are set. Units, feed
//!   rate, offsets and the tolerance stay.
//! - G28 and G30 with axis words move to the position that these give, and then move the named axes to the
//!   stored position.
//!
//! Where this reader differs from grbl 1.1:
//!
//! - It reads files, so it has no real-time bytes: `?`, `!`, `~` and bytes from 0x80 on are errors outside of
//!   comments. A program that reads a serial line must remove them first.
//! - An offset of an arc that is not in its plane is refused (36), and so is an arc of radius 0 (33).
//! - N, T, L, P of G10 and M with fractions are refused, not truncated.
//! - G64 is accepted, for which grbl has error 20: the planner decides how fast a corner is passed. P of G64,
//!   the largest distance of the path from its lines, is a mode, [`Modal::tolerance`]. Moves are as exact as
//!   with G61.
//! - An arc is a full circle if it ends exactly where it starts, or on the line from its centre through its
//!   start. In grbl it is also one if it ends nearly there, within 5 · 10⁻⁷ radians.

#![no_std]
#![cfg_attr(not(feature = "prove"), forbid(unsafe_code))]

mod arc;
mod block;
mod decimal;
mod error;
mod geometry;
mod length;
mod lexer;
mod modal;
#[cfg(all(feature = "prove", target_family = "wasm"))]
mod prove;
mod reader;
mod state;
mod words;

pub use block::{Arc, Block, Effect, FeedRate, Move, MoveKind, Parameter, Stop};
pub use decimal::Decimal;
pub use error::{Error, Fault};
pub use length::{Length, Point};
pub use modal::{Coolant, Modal, MotionMode, Plane, Probe, Spindle, SpindleMode, System};
pub use reader::{Options, Reader};
