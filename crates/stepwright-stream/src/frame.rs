//! Frames: what a host sends.
//!
//! ```text
//!   ┌─────────┬─────┬─────┬──────────────────┬───────┬───────┐
//!   │ 0x80+kind│ len │ seq │ payload, len ≤ 59 │ CRC lo│ CRC hi│
//!   └─────────┴─────┴─────┴──────────────────┴───────┴───────┘
//! ```
//!
//! A first byte of 0x80 or more begins a frame; any other byte belongs to a text line. The checksum covers
//! all bytes before it ([`crate::crc`]). The sequence number counts from 0 to 255 and wraps. A board takes
//! the number that it expects and no other.
//!
//! No frame contains four bytes of [`FILL`] in a row: four of them end a board's [deafness](crate::link).

use crate::crc;

/// Four of these bytes in a row reset a board's link.
pub const FILL: u8 = 0xFF;
/// The most bytes of a payload.
pub const LONGEST: usize = 59;
/// Bytes of a frame besides its payload.
pub const AROUND: usize = 5;
/// The most bytes of a frame.
pub const MOST: usize = LONGEST + AROUND;

/// The most bytes of data in a cut.
pub const CUT: usize = 16;

/// The kind of a frame: its first byte.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// A sign of life. The board answers it. A ping has no number and no payload.
    Ping = 0x80,
    /// A [gate](crate::record) and records.
    Data = 0x81,
    /// The [brakes](crate::brake::BrakeLaw) of all axes, 6 bytes each. The board forgets everything else.
    Setup = 0x82,
    /// Starts the run. Four bytes: the axes that take part; the lease in 8 ms, 0 for none; the inputs that
    /// stop, as bits: 0 to 2 the axes' switches, 6 the drivers' fault, 7 the emergency stop; and those among
    /// them that stop when they open, not when they close.
    Start = 0x83,
    /// Takes back the data frames from this number on, and the end: the number counts data frames since the
    /// setup, modulo 256. A gate and records of at most [`CUT`] bytes may follow, which come in their place.
    /// A board that has opened such a frame, or has reached the end of the run, does not take the cut.
    Cut = 0x84,
    /// Ends the run with the last record.
    End = 0x85,
}

impl Kind {
    /// The kind with this first byte.
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
    /// A frame with this number. Payload beyond [`LONGEST`] is dropped.
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

    /// Whether the frame has four bytes of [`FILL`] in a row.
    pub fn is_barred(&self) -> bool {
        self.as_bytes().windows(4).any(|four| four == [FILL; 4])
    }
}
