//! Credit: a board's answer to frames.
//!
//! ```text
//!   ┌──────┬──────────┬────────┬────────┬───────┬───────┬───────┐
//!   │ 0x80 │ next seq │ opened │ free/8 │ flags │ CRC lo│ CRC hi│
//!   └──────┴──────────┴────────┴────────┴───────┴───────┴───────┘
//! ```
//!
//! It may come in the middle of a text answer, as bytes of text are all below 0x80.

use crate::crc;

/// The first byte of a credit.
pub const HEAD: u8 = 0x80;
/// The number of bytes of a credit.
pub const LEN: usize = 7;

/// The state of a board's stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Credit {
    /// The number of the next expected frame: the board has all frames before it.
    pub next: u8,
    /// The number of data frames opened since the last setup, modulo 256.
    pub opened: u8,
    /// Free bytes of the FIFO divided by 8, rounded down; 255 for more.
    pub free: u8,
    /// The flags below.
    pub flags: u8,
}

impl Credit {
    /// The board has braked, and is off the path until the next setup.
    pub const OFF: u8 = 1;
    /// The board received a broken frame, and is deaf until four [`FILL`](crate::frame::FILL).
    pub const DEAF: u8 = 2;
    /// An axis moves, or waits for its next entry.
    pub const MOVES: u8 = 4;
    /// The board has refused a record.
    pub const WRONG: u8 = 8;
    /// The run was started since the last setup.
    pub const STARTED: u8 = 16;

    /// A watched input has stopped the axes: it has closed, or has opened if it stops when it opens.
    pub const TRIPPED: u8 = 32;

    /// Whether a flag is set.
    pub const fn is(self, flag: u8) -> bool {
        self.flags & flag != 0
    }

    /// The bytes on the line.
    pub fn bytes(self) -> [u8; LEN] {
        let Credit { next, opened, free, flags } = self;
        let [low, high] = crc::of(&[HEAD, next, opened, free, flags]).to_le_bytes();
        [HEAD, next, opened, free, flags, low, high]
    }
}

/// Separates credits from the text among the bytes of a board.
#[derive(Clone, Debug, Default)]
pub struct CreditReader {
    bytes: [u8; LEN],
    len: u8,
}

/// A credit or a byte of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answered {
    /// The state of the stream.
    Credit(Credit),
    /// A byte of text.
    Text(u8),
}

impl CreditReader {
    /// A reader that has read nothing.
    pub const fn new() -> CreditReader {
        CreditReader { bytes: [0; LEN], len: 0 }
    }

    /// Takes a byte, and calls `told` with each credit or byte of text that it completes. Bytes that began
    /// like a credit but are not one are searched again from the second byte on.
    ///
    /// ```
    /// use stepwright_stream::credit::{Answered, Credit, CreditReader};
    /// let credit = Credit { next: 3, opened: 1, free: 90, flags: 0 };
    /// let mut reader = CreditReader::new();
    /// let (mut found, mut text) = (Vec::new(), Vec::new());
    /// for byte in [b"1\x802", &credit.bytes()[..], b"5\r"].concat() {
    ///     reader.hear(byte, |told| match told {
    ///         Answered::Credit(credit) => found.push(credit),
    ///         Answered::Text(byte) => text.push(byte),
    ///     });
    /// }
    /// assert_eq!((&found[..], &text[..]), (&[credit][..], &b"125\r"[..]));
    /// ```
    pub fn hear(&mut self, byte: u8, mut told: impl FnMut(Answered)) {
        if self.len == 0 && byte < 0x80 {
            return told(Answered::Text(byte));
        }
        if let Some(place) = self.bytes.get_mut(usize::from(self.len)) {
            *place = byte;
            self.len = self.len.wrapping_add(1);
        }
        while self.len != 0 {
            let [head, next, opened, free, flags, ..] = self.bytes;
            if head == HEAD {
                if usize::from(self.len) < LEN {
                    return;
                }
                let credit = Credit { next, opened, free, flags };
                if credit.bytes() == self.bytes {
                    self.len = 0;
                    return told(Answered::Credit(credit));
                }
            } else if head < 0x80 {
                told(Answered::Text(head));
            }
            self.bytes.rotate_left(1);
            self.len = self.len.wrapping_sub(1);
        }
    }
}
