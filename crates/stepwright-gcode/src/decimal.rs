//! Decimal numbers, exactly as they are written.

use core::fmt;

use crate::Fault;

/// An exact decimal number: seven digits before the point, eleven after.
///
/// Further digits after the point are rounded to the nearest, a half away from 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Decimal(i64);

impl Decimal {
    /// 0.
    pub const ZERO: Decimal = Decimal(0);
    /// Digits after the point.
    pub const DIGITS: u32 = 11;
    /// The number 1, [`scaled`](Self::scaled).
    pub const SCALE: i64 = 10_i64.pow(Self::DIGITS);

    /// The number times [`SCALE`](Self::SCALE), from −10¹⁸ to 10¹⁸.
    pub const fn scaled(self) -> i64 {
        self.0
    }

    /// The number, if it is whole.
    pub(crate) const fn whole(self) -> Option<i64> {
        if self.0 % Self::SCALE == 0 { Some(self.0 / Self::SCALE) } else { None }
    }

    /// The number in tenths, if it has no smaller part: 382 for `G38.2`.
    pub(crate) const fn tenths(self) -> Option<i64> {
        const TENTH: i64 = Decimal::SCALE / 10;
        if self.0 % TENTH == 0 { Some(self.0 / TENTH) } else { None }
    }
}

impl fmt::Display for Decimal {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fixed(f, self.0, Self::DIGITS)
    }
}

/// Prints `scaled` / 10^`digits`, without zeros at the end.
pub(crate) fn fixed(f: &mut fmt::Formatter, scaled: i64, digits: u32) -> fmt::Result {
    let one = 10_u64.pow(digits);
    let (whole, mut rest) = (scaled.unsigned_abs() / one, scaled.unsigned_abs() % one);
    let mut width = digits as usize;
    while width > 0 && rest.is_multiple_of(10) {
        rest /= 10;
        width -= 1;
    }
    if scaled < 0 {
        f.write_str("-")?;
    }
    write!(f, "{whole}")?;
    if width > 0 { write!(f, ".{rest:0width$}") } else { Ok(()) }
}

/// Reads a number, a byte at a time: sign, digits, point, digits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Scanner {
    part: Part,
    negative: bool,
    has_digits: bool,
    too_large: bool,
    /// All digits so far, except those beyond the eleventh after the point.
    digits: u64,
    /// The number of digits after the point, in `digits` or not; at most 12.
    after_point: u32,
    /// Whether the first digit beyond the eleventh rounds up.
    round_up: bool,
}

/// The part of a number to which the next byte belongs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Part {
    #[default]
    Sign,
    Whole,
    Fraction,
}

impl Scanner {
    /// Takes a byte that continues the number; `false` if it does not.
    pub fn push(&mut self, byte: u8) -> bool {
        match (byte, self.part) {
            (b'+' | b'-', Part::Sign) => {
                self.negative = byte == b'-';
                self.part = Part::Whole;
            }
            (b'.', Part::Sign | Part::Whole) => self.part = Part::Fraction,
            (b'0'..=b'9', part) => {
                self.has_digits = true;
                self.digit(u64::from(byte - b'0'), part == Part::Fraction);
                if part == Part::Sign {
                    self.part = Part::Whole;
                }
            }
            _ => return false,
        }
        true
    }

    fn digit(&mut self, digit: u64, fraction: bool) {
        if fraction {
            if self.after_point > Decimal::DIGITS {
                return;
            }
            self.after_point += 1;
            if self.after_point > Decimal::DIGITS {
                self.round_up = digit >= 5;
                return;
            }
        } else if self.digits >= 1_000_000 {
            self.too_large = true;
            return;
        }
        // Below 10⁷ · 10¹¹.
        self.digits = self.digits * 10 + digit;
    }

    /// The number, after a byte that does not continue it.
    pub fn finish(&self) -> Result<Decimal, Fault> {
        if !self.has_digits {
            return Err(Fault::Number);
        }
        if self.too_large {
            return Err(Fault::TooLarge);
        }
        let scale = 10_u64.pow(Decimal::DIGITS.saturating_sub(self.after_point));
        let scaled = (self.digits * scale + u64::from(self.round_up)) as i64;
        Ok(Decimal(if self.negative { -scaled } else { scaled }))
    }
}

/// Reads a whole text as one number, for tests.
#[cfg(test)]
pub(crate) fn parse(text: &str) -> Result<Decimal, Fault> {
    let mut scanner = Scanner::default();
    if text.bytes().all(|byte| scanner.push(byte)) { scanner.finish() } else { Err(Fault::Letter) }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::string::ToString;

    use super::*;

    #[test]
    fn numbers_are_read_and_printed_as_they_are() {
        for (text, scaled, printed) in [
            ("0", 0, "0"),
            ("-0", 0, "0"),
            ("1", 100_000_000_000, "1"),
            ("+1.", 100_000_000_000, "1"),
            (".5", 50_000_000_000, "0.5"),
            ("-.05", -5_000_000_000, "-0.05"),
            ("000000000012.50", 1_250_000_000_000, "12.5"),
            ("9999999.99999999999", 999_999_999_999_999_999, "9999999.99999999999"),
            ("-9999999.999999999995", -1_000_000_000_000_000_000, "-10000000"),
            ("0.00000000001", 1, "0.00000000001"),
            ("0.000000000014999999999", 1, "0.00000000001"),
            ("0.000000000015", 2, "0.00000000002"),
            ("0.0000000000050", 1, "0.00000000001"),
        ] {
            let number = parse(text).unwrap();
            assert_eq!((number.scaled(), number.to_string().as_str()), (scaled, printed), "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in ["", "+", "-", ".", "-."] {
            assert_eq!(parse(text), Err(Fault::Number), "{text:?}");
        }
        for text in ["10000000", "-10000000.0", "123456789012345678901234567890"] {
            assert_eq!(parse(text), Err(Fault::TooLarge), "{text}");
        }
        for text in ["--1", "1-", "1.2.3", "..", "1e5", "+ 1"] {
            assert_eq!(parse(text), Err(Fault::Letter), "{text}");
        }
    }

    #[test]
    fn whole_numbers_and_tenths_are_told_from_others() {
        assert_eq!(parse("28.1").unwrap().tenths(), Some(281));
        assert_eq!(parse("28.10").unwrap().tenths(), Some(281));
        assert_eq!(parse("28.11").unwrap().tenths(), None);
        assert_eq!(parse("3.0").unwrap().whole(), Some(3));
        assert_eq!(parse("3.00000000001").unwrap().whole(), None);
    }
}
