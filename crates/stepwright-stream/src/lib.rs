#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
//! Streamed runs: a host plans, a board plays.
//!
//! The host plans runs of any length by any law. The board plays them, and brakes by itself when nothing
//! comes any more. The line carries [entries](stepwright::entry) of all axes, compressed to some five bytes
//! each, in frames beside the text lines of the same wire.
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
//! | [`frame`], [`crc`] | frames, from host to board |
//! | [`credit`] | answers, from board to host |
//! | [`record`] | compressed entries: encoder and decoder |
//! | [`power`] | changes of a laser's power among the records |
//! | [`fifo`], [`link`] | the board's end of the line |
//! | [`brake`] | how an axis comes to rest by itself |
//! | [`player`] | the board's state machine over the queues of its axes |
//! | [`fit`] | steps with times become records |
//! | [`pack`], [`send`] | the host's end: records into frames, frames onto the wire |
//!
//! The whole format, its state machines and measurements: `docs/stream.md` in the repository.

pub mod brake;
pub mod crc;
pub mod credit;
pub mod fifo;
pub mod fit;
pub mod frame;
pub mod link;
pub mod pack;
pub mod player;
pub mod power;
pub mod record;
pub mod send;
