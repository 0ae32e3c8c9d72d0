//! A board's end of the link: bytes become frames, and text.
//!
//! ```text
//!             0x80 …            ┌──────────────────────────────────────────┐
//!   ┌─ idle ─────────► head ─► length ─► number ─► payload ─► CRC ─► good: │ taken, if expected
//!   │   ▲ text below 0x80                                       │    ─────►┘
//!   │   │                                                       └ bad
//!   │   └──────── four FILL in a row ◄──────────── deaf ◄────────┘
//! ```
//!
//! After a frame whose first byte was damaged, its payload looks like text: so a link that has heard
//! something broken is *deaf*, for text too, until four [`FILL`] in a row. A byte below 0x20 that ends
//! no line is broken as well. No frame has four of them in it, and they bring the link to its
//! beginning at any time.

use crate::crc;
use crate::fifo::Fifo;
use crate::frame::{FILL, Kind, LONGEST};

/// Where the link is.
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

/// What a byte was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Came {
    /// A part of a frame, or nothing.
    Nothing,
    /// Of a text line.
    Text(u8),
    /// A frame is whole, of this kind and this number. One of data waits in the FIFO, to be
    /// [committed](FrameLink::data) or left.
    Frame(Kind, u8),
    /// Something broken: the link is deaf from here on.
    Broken,
    /// A byte of a text line was lost, or is the first of a call.
    Garbled,
    /// Four [`FILL`]: all begins again, a text line too.
    Called,
}

/// The most bytes of a payload that is no data.
pub const SMALL: usize = 18;

/// A board's end of the link, with the FIFO where data go.
#[derive(Clone, Debug)]
pub struct FrameLink<const LEN: usize> {
    phase: Phase,
    fills: u8,
    head: u8,
    /// Bytes of the payload, and those that came.
    need: u8,
    have: u8,
    number: u8,
    sum: u16,
    low: u8,
    small: [u8; SMALL],
    fifo: Fifo<LEN>,
}

impl<const LEN: usize> FrameLink<LEN> {
    /// Nothing has come.
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

    /// Whether it hears nothing.
    pub fn is_deaf(&self) -> bool {
        self.phase == Phase::Deaf
    }

    /// Where data wait.
    #[inline(always)]
    pub fn fifo(&mut self) -> &mut Fifo<LEN> {
        &mut self.fifo
    }

    /// The payload of the last frame that was no data; what it lacked is 0.
    pub fn small(&self) -> &[u8; SMALL] {
        &self.small
    }

    /// Bytes of that payload, at most [`SMALL`].
    pub fn small_len(&self) -> u8 {
        self.have.min(SMALL as u8)
    }

    /// Puts the frame of data that has just come behind those in the FIFO; false if there was no room.
    pub fn data(&mut self) -> bool {
        self.fifo.commit()
    }

    /// Takes a byte; `None` is one that was lost or damaged, of which a small chip says [`FILL`].
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

    /// A byte between two frames.
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
        // Of what is broken anyway nothing new is said.
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
