//! What a board answers to frames.
//!
//! ```text
//!   ┌──────┬──────────┬────────┬────────┬───────┬───────┬───────┐
//!   │ 0x80 │ next seq │ opened │ free/8 │ flags │ CRC lo│ CRC hi│
//!   └──────┴──────────┴────────┴────────┴───────┴───────┴───────┘
//! ```
//!
//! It may stand in the middle of a text answer, whose bytes are all below 0x80.

use crate::crc;

/// Its first byte.
pub const HEAD: u8 = 0x80;
/// Its bytes.
pub const LEN: usize = 7;

/// How a board's stream stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Credit {
    /// The number of the frame that is expected: all before it are there.
    pub next: u8,
    /// Frames of data that were opened since the last setup, modulo 256.
    pub opened: u8,
    /// Free bytes of the FIFO, in 8 and rounded down; 255 for more.
    pub free: u8,
    /// Of the constants below.
    pub flags: u8,
}

impl Credit {
    /// An axis has braked: off the path until the next setup.
    pub const OFF: u8 = 1;
    /// A frame came damaged: nothing is heard until four [`FILL`](crate::frame::FILL).
    pub const DEAF: u8 = 2;
    /// An axis moves, or waits for what follows.
    pub const MOVES: u8 = 4;
    /// A record was none that can be played.
    pub const WRONG: u8 = 8;
    /// A start was obeyed since the last setup.
    pub const STARTED: u8 = 16;

    /// An input that is watched has stopped the axes: it has closed, or opened where it is one that
    /// stops then.
    pub const TRIPPED: u8 = 32;

    /// Whether a flag is there.
    pub const fn is(self, flag: u8) -> bool {
        self.flags & flag != 0
    }

    /// As it is sent.
    pub fn bytes(self) -> [u8; LEN] {
        let Credit { next, opened, free, flags } = self;
        let [low, high] = crc::of(&[HEAD, next, opened, free, flags]).to_le_bytes();
        [HEAD, next, opened, free, flags, low, high]
    }
}

/// Finds answers among the bytes that come, and leaves the others as text.
#[derive(Clone, Debug, Default)]
pub struct CreditReader {
    bytes: [u8; LEN],
    len: u8,
}

/// What a byte has completed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answered {
    /// How the stream stands.
    Credit(Credit),
    /// A byte of text.
    Text(u8),
}

impl CreditReader {
    /// At the beginning.
    pub const fn new() -> CreditReader {
        CreditReader { bytes: [0; LEN], len: 0 }
    }

    /// Takes a byte; tells what that has completed. What began as an answer and is none is looked
    /// through again behind its first byte.
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
