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
    Number(u64),
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
    next_byte: u8,
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
                Piece::Number(value) => self.number = Decimal::new(value),
            }
            self.next_piece = self.next_piece.saturating_add(1);
        }
    }
}

/// The digits of a number that are still to be sent, the last digit first.
#[derive(Clone, Debug)]
struct Decimal {
    digits: [u8; 20], // 2⁶⁴ has 20
    len: u8,
}

impl Decimal {
    const NONE: Decimal = Decimal { digits: [0; 20], len: 0 };

    /// Takes the bits of `value` from the top and doubles a decimal number
    /// for each. It needs no division, which an 8-bit chip does bit by bit
    /// anyway, and costs little for leading zeros.
    fn new(mut value: u64) -> Decimal {
        let mut decimal = Decimal::NONE;
        for _ in 0..u64::BITS {
            let mut carry = u8::from((value as i64) < 0);
            value <<= 1;
            for digit in decimal.digits.iter_mut().take(decimal.len.into()) {
                *digit = *digit << 1 | carry;
                carry = u8::from(*digit > 9);
                if carry == 1 {
                    *digit = digit.wrapping_sub(10);
                }
            }
            if carry == 1
                && let Some(digit) = decimal.digits.get_mut(usize::from(decimal.len))
            {
                *digit = 1;
                decimal.len = decimal.len.saturating_add(1);
            }
        }
        if decimal.len == 0 {
            decimal.len = 1; // zero is written "0"
        }
        decimal
    }

    fn next(&mut self) -> Option<u8> {
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
        let mut decimal = Decimal::new(value);
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
