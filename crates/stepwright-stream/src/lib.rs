#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
//! Runs that a host streams to a board.
//!
//! A host plans, at any length and by any law; a board plays, and brakes by itself when nothing
//! comes any more. What goes over the line are [entries](stepwright::entry) of all axes, compressed
//! to some five bytes, in frames beside the text lines of the same wire.
//!
//! ```text
//!   host                                              │  board
//!                                                     │
//!   steps ─► fit ──► record ──► pack ──► send ──frames──► link ─► fifo ─► player ─► queues ─► pins
//!           entries  bytes     frames   window, again │                    │ silence
//!                                        ◄──credit──────────────────────── └► brake
//! ```
//!
//! | file | content |
//! | --- | --- |
//! | [`frame`], [`crc`] | frames, host to board |
//! | [`credit`] | answers, board to host |
//! | [`record`] | compressed entries: encoder and decoder |
//! | [`fifo`], [`link`] | a board's end of the line |
//! | [`brake`] | how an axis comes to rest by itself |
//! | [`player`] | the board's state machine over the queues of its axes |
//! | [`fit`] | steps with times become entries |
//! | [`pack`], [`send`] | a host's end: entries into frames, frames onto the wire |
//!
//! The whole format, its state machines and what was measured: `docs/stream.md` in the repository.

pub mod brake;
pub mod crc;
pub mod credit;
pub mod fifo;
pub mod fit;
pub mod frame;
pub mod link;
pub mod pack;
pub mod player;
pub mod record;
pub mod send;
