//! Frames: what a host sends.
//!
//! ```text
//!   ┌─────────┬─────┬─────┬──────────────────┬───────┬───────┐
//!   │ 0x80+kind│ len │ seq │ payload, len ≤ 59 │ CRC lo│ CRC hi│
//!   └─────────┴─────┴─────┴──────────────────┴───────┴───────┘
//! ```
//!
//! A first byte of 0x80 and more begins a frame, any other is of a text line. The checksum is that
//! of all bytes before it ([`crate::crc`]). Frames count 0 to 255 and round again; a board
//! takes the one that it expects and no other.
//!
//! No frame has four bytes of [`FILL`] in a row, whatever is in it: four of them end a board's
//! [deafness](crate::link).

use crate::crc;

/// Four in a row bring a board's link to its beginning.
pub const FILL: u8 = 0xFF;
/// The most bytes of a payload.
pub const LONGEST: usize = 59;
/// Bytes of a frame besides its payload.
pub const AROUND: usize = 5;
/// The most bytes of a frame.
pub const MOST: usize = LONGEST + AROUND;

/// The most bytes of data that a cut brings with it.
pub const CUT: usize = 16;

/// What a frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Nothing but a sign of life, which is answered. It has no number, and no payload.
    Ping = 0x80,
    /// A [gate](crate::record) and records.
    Data = 0x81,
    /// The [brakes](crate::brake::BrakeLaw) of all axes, 6 bytes each. All else is forgotten.
    Setup = 0x82,
    /// All axes begin: which ones; the lease in 8 ms, 0 for none; inputs that stop, as bits: 0 to 2
    /// the axes' switches, 6 the drivers' fault, 7 the emergency stop; of these, the ones that stop
    /// when they open, not when they close.
    Start = 0x83,
    /// Frames of data from this number on are forgotten, and the end: modulo 256, counted from the setup. Then, if
    /// any, a gate and records of at most [`CUT`] bytes, which come in their place. A board that has
    /// opened such a frame, or has come to its end, does not take the cut.
    Cut = 0x84,
    /// No more will come: the last record's end is the end.
    End = 0x85,
}

impl Kind {
    /// The kind whose first byte this is.
    pub const fn of(head: u8) -> Option<Kind> {
        Some(match head {
            0x80 => Kind::Ping,
            0x81 => Kind::Data,
            0x82 => Kind::Setup,
            0x83 => Kind::Start,
            0x84 => Kind::Cut,
            0x85 => Kind::End,
            _ => return None,
        })
    }
}

/// The bytes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameBytes {
    bytes: [u8; MOST],
    len: u8,
}

impl FrameBytes {
    /// A frame with this number. What is longer than [`LONGEST`] falls off.
    ///
    /// ```
    /// use stepwright_stream::frame::{FrameBytes, Kind};
    /// let frame = FrameBytes::new(Kind::Start, 7, &[0b11, 25]);
    /// assert_eq!(frame.as_bytes()[..5], [0x83, 2, 7, 0b11, 25]);
    /// assert_eq!(frame.as_bytes().len(), 7);
    /// ```
    pub fn new(kind: Kind, seq: u8, payload: &[u8]) -> FrameBytes {
        let len = payload.len().min(LONGEST) as u8;
        let mut frame = FrameBytes { bytes: [0; MOST], len: 0 };
        for byte in [kind as u8, len, seq] {
            frame.push(byte);
        }
        for byte in payload.iter().take(LONGEST) {
            frame.push(*byte);
        }
        let [low, high] = crc::of(frame.as_bytes()).to_le_bytes();
        frame.push(low);
        frame.push(high);
        frame
    }

    fn push(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(usize::from(self.len)) {
            *place = byte;
            self.len = self.len.wrapping_add(1);
        }
    }

    /// The bytes, in order.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.len)).unwrap_or(&[])
    }

    /// Whether it has four bytes of [`FILL`] in a row.
    pub fn is_barred(&self) -> bool {
        self.as_bytes().windows(4).any(|four| four == [FILL; 4])
    }
}
