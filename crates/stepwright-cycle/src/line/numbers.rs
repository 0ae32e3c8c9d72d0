//! The numbers of a line, and its checksum.

use super::LineFault;
use crate::program::DelayRamp;

/// Hexadecimal numbers with commas between them, read one by one.
pub(super) struct Numbers<'t> {
    /// What is left; `None` behind the last one.
    rest: Option<&'t [u8]>,
    /// How many were read.
    read: u8,
    /// What was wrong with the one that was not: here, and not in each result, of which a small
    /// chip would copy it.
    pub fault: LineFault,
}

impl<'t> Numbers<'t> {
    pub(super) fn of(text: &'t [u8]) -> Numbers<'t> {
        let rest = (!text.is_empty()).then_some(text);
        Numbers { rest, read: 0, fault: LineFault::Unknown }
    }

    /// The next one.
    #[inline(never)]
    pub(super) fn next(&mut self) -> Option<i64> {
        let text = self.rest?;
        self.read = self.read.wrapping_add(1);
        let (minus, text) = match text {
            [b'-', text @ ..] => (true, text),
            text => (false, text),
        };
        let (mut number, mut digits, mut rest) = (0i64, 0u8, None);
        let mut text = text;
        while let [byte, after @ ..] = text {
            text = after;
            if *byte == b',' {
                rest = Some(after);
                break;
            }
            let digit = match byte {
                b'0'..=b'9' => byte.wrapping_sub(b'0'),
                b'A'..=b'F' => byte.wrapping_sub(b'A' - 10),
                b'a'..=b'f' => byte.wrapping_sub(b'a' - 10),
                _ => return None,
            };
            if digits > 0 && number >> 59 != 0 {
                // Beyond 63 bits.
                return self.range(i64::MIN + 1, i64::MAX);
            }
            number = number << 4 | i64::from(digit);
            digits = digits.saturating_add(1);
        }
        if digits == 0 {
            return None;
        }
        self.rest = rest;
        Some(if minus { number.wrapping_neg() } else { number })
    }

    /// The present number is out of its range.
    #[cold]
    #[inline(never)]
    fn set_range(&mut self, least: i64, most: i64) {
        self.fault = LineFault::Range { number: self.read, least, most };
    }

    /// Likewise, as the answer to whoever asked for it.
    #[inline(always)] // with the place of its result it would have too many arguments for a Mega
    pub(super) fn range<T>(&mut self, least: i64, most: i64) -> Option<T> {
        self.set_range(least, most);
        None
    }

    /// The next one, from `least` to `most`.
    #[inline(never)]
    pub(super) fn from(&mut self, least: u32, most: u32) -> Option<u32> {
        match u32::try_from(self.next()?) {
            Ok(number) if (least..=most).contains(&number) => Some(number),
            _ => self.range(least.into(), most.into()),
        }
    }

    /// The next one, up to `most`.
    #[inline(never)]
    pub(super) fn upto(&mut self, most: u8) -> Option<u8> {
        self.from(0, most.into()).map(|number| number as u8)
    }

    pub(super) fn flag(&mut self) -> Option<bool> {
        self.upto(1).map(|flag| flag != 0)
    }

    #[inline(never)]
    pub(super) fn delay(&mut self) -> Option<u32> {
        self.from(0, u32::MAX)
    }

    #[inline(never)]
    pub(super) fn count(&mut self) -> Option<i32> {
        match i32::try_from(self.next()?) {
            Ok(count) => Some(count),
            Err(_) => self.range(i32::MIN.into(), i32::MAX.into()),
        }
    }

    pub(super) fn ramp(&mut self) -> Option<DelayRamp> {
        Some(DelayRamp { from: self.delay()?, to: self.delay()?, by: self.delay()? })
    }

    /// Whether there are no more.
    pub(super) fn end(&self) -> bool {
        self.rest.is_none()
    }
}
