//! Lines on their way out, pulled a byte at a time.
//!
//! A line is a few pieces, texts and numbers, and is never stored: at 115200
//! baud a byte takes 87 µs, so a board that had to write the longest answer
//! in one go would stand still for 8 ms or keep 100 bytes of RAM for it.
//! Pulled, it costs its value and one number's digits. `core::fmt` is not
//! used; on an AVR it alone would fill several kilobytes of flash.

use crate::flash::{Text, text};

/// A part of a line.
pub enum Piece {
    /// Fixed text.
    Text(Text),
    /// Decimal digits without leading zeros.
    Number(u32),
}

/// Something that can be written as a line.
pub trait Pieces {
    /// Piece `n`, counted from 0; `None` past the last.
    fn piece(&self, n: u8) -> Option<Piece>;
}

/// The bytes of a line, its CR included: an iterator to pull them from.
///
/// Costs one conversion to decimal where a number begins: about 100 simple
/// byte operations for 4000, 1,400 for 2³² − 1. Texts and further digits cost
/// next to nothing.
#[derive(Clone, Debug)]
pub struct Bytes<L> {
    line: L,
    next_piece: u8,
    text: Text,
    next_byte: u16,
    number: Decimal,
}

impl<L> Bytes<L> {
    pub(crate) fn new(line: L) -> Bytes<L> {
        Bytes { line, next_piece: 0, text: text!(""), next_byte: 0, number: Decimal::NONE }
    }
}

impl<L: Pieces> Iterator for Bytes<L> {
    type Item = u8;

    fn next(&mut self) -> Option<u8> {
        loop {
            if let Some(byte) = self.text.byte(self.next_byte) {
                self.next_byte = self.next_byte.saturating_add(1);
                return Some(byte);
            }
            if let Some(byte) = self.number.next() {
                return Some(byte);
            }
            match self.line.piece(self.next_piece)? {
                Piece::Text(text) => (self.text, self.next_byte) = (text, 0),
                Piece::Number(value) => self.number.set(&value.to_le_bytes()),
            }
            self.next_piece = self.next_piece.saturating_add(1);
        }
    }
}

/// The digits of a number that are still to be sent, the last digit first.
#[derive(Clone, Debug)]
pub(crate) struct Decimal {
    digits: [u8; 20], // 2⁶⁴ has 20
    /// How many there are; what stands behind them is old.
    len: u8,
}

impl Decimal {
    pub(crate) const NONE: Decimal = Decimal { digits: [0; 20], len: 0 };

    /// Takes the bits of a number, whose lowest byte is the first, from the
    /// top and doubles a decimal number for each. It needs no division, which
    /// an 8-bit chip does bit by bit anyway, and costs nothing for leading
    /// zeros.
    #[inline(never)]
    pub(crate) fn set(&mut self, bytes: &[u8]) {
        self.len = 0;
        for byte in bytes.iter().rev() {
            let mut byte = *byte;
            for _ in 0..8u8 {
                self.double_and_add(byte >> 7);
                byte <<= 1;
            }
        }
        if self.len == 0 {
            // Zero is written "0".
            self.digits[0] = 0;
            self.len = 1;
        }
    }

    fn double_and_add(&mut self, mut carry: u8) {
        let Some(digits) = self.digits.get_mut(..usize::from(self.len)) else { return };
        for digit in digits {
            let double = *digit << 1 | carry;
            carry = u8::from(double > 9);
            *digit = if carry == 1 { double.wrapping_sub(10) } else { double };
        }
        if carry == 1
            && let Some(digit) = self.digits.get_mut(usize::from(self.len))
        {
            *digit = 1;
            self.len = self.len.wrapping_add(1);
        }
    }

    pub(crate) fn next(&mut self) -> Option<u8> {
        self.len = self.len.checked_sub(1)?;
        self.digits.get(usize::from(self.len)).map(|digit| digit | b'0')
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::string::{String, ToString};

    fn written(value: u64) -> String {
        let mut decimal = Decimal::NONE;
        decimal.set(&value.to_le_bytes());
        core::iter::from_fn(|| decimal.next()).map(char::from).collect()
    }

    #[test]
    fn edges_are_written_in_full() {
        for value in [0, 1, 9, 10, 99, 100, u32::MAX.into(), u64::MAX] {
            assert_eq!(written(value), value.to_string());
        }
    }

    proptest! {
        #[test]
        fn digits_are_those_of_the_standard_library(value: u64, shift in 0u32..64) {
            let value = value >> shift;
            prop_assert_eq!(written(value), value.to_string());
        }
    }
}
