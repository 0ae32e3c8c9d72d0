//! The board's end of the link: bytes become frames and text.
//!
//! ```text
//!             0x80 …            ┌──────────────────────────────────────────┐
//!   ┌─ idle ─────────► head ─► length ─► number ─► payload ─► CRC ─► good: │ taken, if expected
//!   │   ▲ text below 0x80                                       │    ─────►┘
//!   │   │                                                       └ bad
//!   │   └──────── four FILL in a row ◄──────────── deaf ◄────────┘
//! ```
//!
//! If the first byte of a frame is damaged, its payload looks like text. A link that has received a broken
//! frame is therefore *deaf*, for text too, until four [`FILL`] in a row. A byte below 0x20 that ends no line
//! is broken as well. Four [`FILL`] reset the link at any time; no frame contains them.

use crate::crc;
use crate::fifo::Fifo;
use crate::frame::{FILL, Kind, LONGEST};

/// The state of the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Idle,
    Deaf,
    Length,
    Number,
    Payload,
    Low,
    High,
}

/// The meaning of a received byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Came {
    /// A part of a frame, or nothing.
    Nothing,
    /// A byte of a text line.
    Text(u8),
    /// The last byte of a frame of this kind and number. A data frame is in the FIFO, to be
    /// [committed](FrameLink::data) or dropped.
    Frame(Kind, u8),
    /// A broken frame or byte: the link is deaf from now on.
    Broken,
    /// A lost byte of a text line, or the first [`FILL`] of a call.
    Garbled,
    /// Four [`FILL`]: the link is reset, and a text line begins again.
    Called,
}

/// The most bytes of a payload other than data.
pub const SMALL: usize = 18;

/// The board's end of the link, with the FIFO for data.
#[derive(Clone, Debug)]
pub struct FrameLink<const LEN: usize> {
    phase: Phase,
    fills: u8,
    head: u8,
    /// The length of the payload, and the number of its bytes received.
    need: u8,
    have: u8,
    number: u8,
    sum: u16,
    low: u8,
    small: [u8; SMALL],
    fifo: Fifo<LEN>,
}

impl<const LEN: usize> FrameLink<LEN> {
    /// A link that has received nothing.
    pub const fn new() -> FrameLink<LEN> {
        FrameLink {
            phase: Phase::Idle,
            fills: 0,
            head: 0,
            need: 0,
            have: 0,
            number: 0,
            sum: 0,
            low: 0,
            small: [0; SMALL],
            fifo: Fifo::new(),
        }
    }

    /// Whether the link waits for four [`FILL`].
    pub fn is_deaf(&self) -> bool {
        self.phase == Phase::Deaf
    }

    /// The FIFO of data frames.
    #[inline(always)]
    pub fn fifo(&mut self) -> &mut Fifo<LEN> {
        &mut self.fifo
    }

    /// The payload of the last frame other than data, filled up with 0.
    pub fn small(&self) -> &[u8; SMALL] {
        &self.small
    }

    /// The number of bytes of that payload, at most [`SMALL`].
    pub fn small_len(&self) -> u8 {
        self.have.min(SMALL as u8)
    }

    /// Appends the data frame that has just come to the FIFO; false if there was no room.
    pub fn data(&mut self) -> bool {
        self.fifo.commit()
    }

    /// Takes a byte. `None` stands for a lost or damaged byte, and counts as [`FILL`].
    #[inline(always)]
    pub fn hear(&mut self, byte: Option<u8>) -> Came {
        let byte = match byte {
            Some(byte) => byte,
            None => FILL,
        };
        if byte == FILL {
            self.fills = self.fills.wrapping_add(1);
            if self.fills >= 4 {
                (self.phase, self.fills) = (Phase::Idle, 0);
                return Came::Called;
            }
        } else {
            self.fills = 0;
        }
        match self.phase {
            Phase::Payload => {
                self.sum = crc::with(self.sum, byte);
                if self.head == Kind::Data as u8 {
                    self.fifo.write(byte);
                } else if let Some(place) = self.small.get_mut(usize::from(self.have)) {
                    *place = byte;
                }
                self.have = self.have.wrapping_add(1);
                if self.have == self.need {
                    self.phase = Phase::Low;
                }
            }
            Phase::Idle => return self.begin(byte),
            Phase::Deaf => {}
            Phase::Length => {
                self.sum = crc::with(self.sum, byte);
                if usize::from(byte) > LONGEST {
                    return self.broken();
                }
                (self.need, self.have, self.phase) = (byte, 0, Phase::Number);
                if self.head == Kind::Data as u8 {
                    self.fifo.begin();
                    self.fifo.write(byte);
                } else {
                    self.small = [0; SMALL];
                }
            }
            Phase::Number => {
                self.sum = crc::with(self.sum, byte);
                self.number = byte;
                self.phase = if self.need == 0 { Phase::Low } else { Phase::Payload };
            }
            Phase::Low => (self.low, self.phase) = (byte, Phase::High),
            Phase::High => {
                let right = self.sum == u16::from_le_bytes([self.low, byte]);
                let Some(kind) = Kind::of(self.head).filter(|_| right) else {
                    return self.broken();
                };
                self.phase = Phase::Idle;
                return Came::Frame(kind, self.number);
            }
        }
        Came::Nothing
    }

    /// Takes a byte between two frames.
    #[inline(always)]
    fn begin(&mut self, byte: u8) -> Came {
        match byte {
            FILL => Came::Garbled,
            0x80.. => {
                (self.head, self.phase) = (byte, Phase::Length);
                self.sum = crc::with(crc::BEGIN, byte);
                Came::Nothing
            }
            0x20.. | b'\r' | b'\n' => Came::Text(byte),
            _ => self.broken(),
        }
    }

    fn broken(&mut self) -> Came {
        // A deaf link reports no further breaks.
        if self.phase == Phase::Deaf {
            return Came::Nothing;
        }
        self.phase = Phase::Deaf;
        Came::Broken
    }
}

impl<const LEN: usize> Default for FrameLink<LEN> {
    fn default() -> Self {
        FrameLink::new()
    }
}
