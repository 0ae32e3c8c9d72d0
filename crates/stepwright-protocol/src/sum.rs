//! The optional checksum of a line: `LINE*hh`.
//!
//! `hh` is the CRC-8 of the bytes before the `*` (polynomial 0x07, initial value 0, nothing
//! reversed: CRC-8/SMBUS) in two hexadecimal digits. An exclusive-or would be as short, but the
//! same flipped bit in two digits leaves it unchanged, and so does a swap of two digits. This CRC
//! finds every one and two flipped bits in a line of 15 bytes, every odd number of flipped bits in
//! any line, and every burst of up to 8 bits; of other errors, one in 256 passes.

use crate::Refusal;
use crate::crc::crc;
use crate::line::CR;

/// The byte before the two digits. No line contains it otherwise.
const MARK: u8 = b'*';

/// How many bytes a checksum adds to a line.
pub(crate) const LENGTH: usize = 3;

/// The lower half of a byte as a hexadecimal digit.
const fn digit(half: u8) -> u8 {
    match half & 15 {
        half @ 0..10 => b'0' + half,
        half => b'A' + half - 10,
    }
}

/// Whether a line has a checksum, or a damaged one.
pub(crate) fn is_wanted(line: &[u8]) -> bool {
    // Not `contains`, which takes 300 bytes of an AVR's flash.
    line.iter().fold(false, |wanted, byte| wanted | (*byte == MARK))
}

/// A line without its checksum.
///
/// # Errors
/// [`Refusal::Sum`] if there is no checksum, or a wrong one.
pub(crate) fn checked(line: &[u8]) -> Result<&[u8], Refusal> {
    let [bare @ .., MARK, high, low] = line else { return Err(Refusal::Sum) };
    let sum = bare.iter().fold(0, |sum, byte| crc(sum, *byte));
    // Lower-case digits are allowed.
    let is = |half: u8, raw: u8| digit(half) == raw.to_ascii_uppercase();
    if is(sum >> 4, *high) && is(sum, *low) { Ok(bare) } else { Err(Refusal::Sum) }
}

/// Appends the checksum to a line that is sent a byte at a time.
#[derive(Clone, Debug)]
pub(crate) struct Tail {
    wanted: bool,
    sum: u8,
    /// The bytes after the mark that are still to be sent, including the CR.
    left: u8,
}

impl Tail {
    /// For a line without a checksum.
    pub(crate) const NONE: Tail = Tail { wanted: false, sum: 0, left: 0 };

    /// For a line with a checksum, if `wanted`.
    pub(crate) const fn new(wanted: bool) -> Tail {
        Tail { wanted, ..Tail::NONE }
    }

    /// Whether bytes after the mark are still to be sent.
    pub(crate) fn is_left(&self) -> bool {
        self.left != 0
    }

    /// The byte to send before the line's next byte is requested.
    pub(crate) fn next(&mut self) -> Option<u8> {
        self.left = self.left.checked_sub(1)?;
        Some(match self.left {
            2 => digit(self.sum >> 4),
            1 => digit(self.sum),
            _ => CR,
        })
    }

    /// The byte to send for a byte of the line: the byte itself, or the mark in place of its CR.
    pub(crate) fn pass(&mut self, byte: u8) -> u8 {
        if !self.wanted {
            return byte;
        }
        if byte == CR {
            self.left = LENGTH as u8;
            return MARK;
        }
        self.sum = crc(self.sum, byte);
        byte
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn summed(line: &[u8]) -> Vec<u8> {
        let (mut tail, mut sent) = (Tail::new(true), Vec::new());
        for byte in line.iter().chain(b"\r") {
            sent.push(tail.pass(*byte));
            sent.extend(core::iter::from_fn(|| tail.next()));
        }
        assert_eq!(sent.pop(), Some(CR));
        sent
    }

    #[test]
    fn the_sum_is_the_known_one() {
        // The check value of CRC-8/SMBUS.
        assert_eq!(b"123456789".iter().fold(0, |sum, byte| crc(sum, *byte)), 0xF4);
        assert_eq!(summed(b"123456789"), b"123456789*F4");
        assert_eq!(summed(b""), b"*00");
    }

    #[test]
    fn a_line_is_checked() {
        assert_eq!(checked(b"123456789*F4"), Ok(&b"123456789"[..]));
        assert_eq!(checked(b"123456789*f4"), Ok(&b"123456789"[..]));
        for line in [&b"123456789*F5"[..], b"123456788*F4", b"*", b"*0", b"F4", b"", b"1*F4*F4"] {
            assert_eq!(checked(line), Err(Refusal::Sum), "{line:?}");
        }
    }

    proptest! {
        #[test]
        fn what_is_sent_is_right(line in "[A-Za-z0-9+$=-]{0,24}") {
            let sent = summed(line.as_bytes());
            prop_assert_eq!(checked(&sent), Ok(line.as_bytes()));
        }

        /// No flip of one or two bits turns the line into another, nor does a swap of two bytes.
        #[test]
        fn a_flipped_digit_is_found(line in "[A-Z][+-][0-9]{1,10}", a in 0usize..120, b in 0usize..120) {
            let right = summed(line.as_bytes());
            let mut wrong = right.clone();
            for at in [a, b] {
                let at = at % (8 * (right.len() - 2));
                wrong[at / 8] ^= 1 << (at % 8);
            }
            prop_assert!(wrong == right || checked(&wrong) != Ok(&wrong[..wrong.len() - 3]));
            let mut swapped = right.clone();
            swapped.swap(a % line.len(), b % line.len());
            prop_assert!(swapped == right || checked(&swapped).is_err());
        }
    }
}
