//! Lines, sent a byte at a time.
//!
//! A line is a few pieces, texts and numbers, and is never stored: at 115200 baud a byte takes 87
//! µs, so a board that had to write the longest answer in one go would block for 35 ms or need 400
//! bytes of RAM for it. Byte by byte, it needs its value and the digits of one number. `core::fmt`
//! is not used; on an AVR it alone would fill several kilobytes of flash.

use crate::flash::{Text, text};
use crate::sum::Tail;

/// A part of a line.
#[derive(Clone, Copy, Debug)]
pub enum Piece {
    /// Fixed text.
    Text(Text),
    /// Decimal digits without leading zeros.
    Number(u32),
}

/// A value that can be written as a line.
pub trait Pieces {
    /// Piece `n`, counted from 0; `None` past the last.
    fn piece(&self, n: u8) -> Option<Piece>;
}

/// An iterator over the bytes of a line, including the CR.
///
/// A number costs one conversion to decimal where it begins: about 100 simple byte operations for
/// 4000, 1,400 for 2³² − 1. Texts and further digits cost next to nothing.
#[derive(Clone, Debug)]
pub struct Bytes<L> {
    line: L,
    next_piece: u8,
    text: Text,
    next_byte: u16,
    number: Decimal,
    tail: Tail,
}

impl<L> Bytes<L> {
    pub(crate) fn new(line: L) -> Bytes<L> {
        Bytes {
            line,
            next_piece: 0,
            text: text!(""),
            next_byte: 0,
            number: Decimal::NONE,
            tail: Tail::NONE,
        }
    }

    /// The same line with a checksum, if `wanted`.
    pub(crate) fn summed(self, wanted: bool) -> Bytes<L> {
        Bytes { tail: Tail::new(wanted), ..self }
    }
}

impl<L: Pieces> Iterator for Bytes<L> {
    type Item = u8;

    fn next(&mut self) -> Option<u8> {
        if let Some(byte) = self.tail.next() {
            return Some(byte);
        }
        let byte = self.bare()?;
        Some(self.tail.pass(byte))
    }
}

impl<L: Pieces> Bytes<L> {
    /// The next byte, without the checksum.
    #[inline(always)]
    fn bare(&mut self) -> Option<u8> {
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
                Piece::Number(value) => self.number.set(&mut value.to_le_bytes()),
            }
            self.next_piece = self.next_piece.saturating_add(1);
        }
    }
}

/// The digits of a number that are still to be sent, the last digit first.
#[derive(Clone, Debug)]
pub(crate) struct Decimal {
    digits: [u8; 20], // 2⁶⁴ has 20
    /// The number of digits; the bytes after them are old.
    len: u8,
}

impl Decimal {
    pub(crate) const NONE: Decimal = Decimal { digits: [0; 20], len: 0 };

    /// Converts a number of at most 8 bytes, the lowest byte first, and leaves zeros in it. Each
    /// digit is the remainder of a division by ten, from the highest byte that is not zero.
    #[inline(never)]
    pub(crate) fn set(&mut self, mut bytes: &mut [u8]) {
        let mut len = 0u8;
        loop {
            while let [lower @ .., 0] = bytes {
                bytes = lower;
            }
            if bytes.is_empty() && len != 0 {
                break;
            }
            let digit = tenth(bytes);
            if let Some(place) = self.digits.get_mut(usize::from(len)) {
                *place = digit;
            }
            len = len.wrapping_add(1);
        }
        self.len = len;
    }

    pub(crate) fn next(&mut self) -> Option<u8> {
        self.len = self.len.checked_sub(1)?;
        self.digits.get(usize::from(self.len)).map(|digit| digit | b'0')
    }
}

/// Divides a number, the lowest byte first, by ten in place, and returns the remainder.
///
/// For a remainder d and the next byte b: 256 d + b = 10 · 25 d + (6 d + b), where 6 d + b is at
/// most 309.
#[cfg(not(target_arch = "avr"))]
fn tenth(bytes: &mut [u8]) -> u8 {
    bytes.iter_mut().rev().fold(0, |digit, byte| {
        let rest = u16::from(*byte).wrapping_add(u16::from(digit).wrapping_mul(6));
        *byte = digit.wrapping_mul(25).wrapping_add((rest / 10) as u8);
        (rest % 10) as u8
    })
}

/// The same in 30 cycles a byte. (Compiled code takes twice the time and saves all registers.) A
/// fifth of a byte is 205/1024 of it.
#[cfg(target_arch = "avr")]
#[allow(unsafe_code)]
#[inline(always)]
fn tenth(bytes: &mut [u8]) -> u8 {
    let mut digit = 0u8;
    // SAFETY: reads and writes the slice's bytes, from the last to the first; r0 is free to use,
    // and r1 is 0 again at the end.
    unsafe {
        core::arch::asm!(
            "rjmp 3f",
            "2: ld {byte}, -Z",
            "ldi {factor}, 6",
            "mul {digit}, {factor}",
            "ldi {factor}, 25",
            "add {byte}, r0",
            "mov {half}, {byte}",
            "ror {half}",
            "mul {digit}, {factor}",
            "mov {digit}, {byte}",
            "mov {byte}, r0",
            "ldi {factor}, 205",
            "mul {half}, {factor}",
            "lsr r1",
            "lsr r1",
            "add {byte}, r1",
            "st Z, {byte}",
            "ldi {factor}, 10",
            "mul r1, {factor}",
            "sub {digit}, r0",
            "3: subi {count}, 1",
            "brcc 2b",
            "clr r1",
            byte = out(reg) _,
            half = out(reg) _,
            factor = out(reg_upper) _,
            digit = inout(reg) digit,
            count = inout(reg_upper) bytes.len() as u8 => _,
            inout("Z") bytes.as_mut_ptr_range().end => _,
            options(nostack),
        );
    }
    digit
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::string::{String, ToString};

    fn written(value: u64) -> String {
        let mut decimal = Decimal::NONE;
        decimal.set(&mut value.to_le_bytes());
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
