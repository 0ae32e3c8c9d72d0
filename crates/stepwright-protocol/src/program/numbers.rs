//! The numbers of a line.

use super::Fault;

/// Decimal numbers separated by commas, read one by one and checked for their ranges.
///
/// ```
/// use stepwright_protocol::{Fault, Numbers};
/// let mut numbers = Numbers::of(b"-4000,7");
/// assert_eq!((numbers.next(), numbers.between(1, 5)), (Some(-4_000), None));
/// assert_eq!(numbers.fault::<()>(), Fault::Range { number: 2, least: 1, most: 5 });
/// ```
pub struct Numbers<'t> {
    /// The text that is left; `None` after the last number.
    rest: Option<&'t [u8]>,
    /// The count of numbers read.
    read: u8,
    /// The range that the failed number violated. It is kept here and not in each result, which a
    /// small chip would copy.
    range: Option<(i64, i64)>,
}

impl<'t> Numbers<'t> {
    /// The numbers of a text; an empty text has none.
    pub fn of(text: &'t [u8]) -> Numbers<'t> {
        Numbers { rest: (!text.is_empty()).then_some(text), read: 0, range: None }
    }

    /// Whether the next number is negative, and its size; `None` if it is not a number, or has more
    /// than 64 bits.
    #[inline(never)]
    fn raw(&mut self) -> Option<(bool, u64)> {
        let mut text = self.rest?;
        self.rest = None;
        self.read = self.read.wrapping_add(1);
        let mut minus = false;
        if let [b'-', digits @ ..] = text {
            (minus, text) = (true, digits);
        }
        let (mut value, mut empty) = (0u64, true);
        while let [byte, after @ ..] = text {
            text = after;
            if *byte == b',' {
                self.rest = Some(after);
                break;
            }
            let digit = byte.wrapping_sub(b'0');
            // An overflow either comes from a value whose high byte is at least 26, or wraps to a
            // smaller value. The test of one byte is short.
            let [.., high] = value.to_le_bytes();
            let next = (value << 3).wrapping_add(value << 1).wrapping_add(digit.into());
            if digit > 9 || high >= 26 || next < value {
                return None;
            }
            (value, empty) = (next, false);
        }
        (!empty).then_some((minus && value != 0, value))
    }

    /// The next number, of 63 bits and a sign.
    #[inline(never)]
    #[allow(clippy::should_implement_trait, reason = "a number that is none ends no iterator")]
    pub fn next(&mut self) -> Option<i64> {
        let (minus, size) = self.raw()?;
        match i64::try_from(size) {
            Ok(number) => Some(if minus { number.wrapping_neg() } else { number }),
            Err(_) => self.range(-i64::MAX, i64::MAX),
        }
    }

    /// The next number, of 64 bits without a sign.
    #[inline(never)]
    pub fn wide(&mut self) -> Option<u64> {
        let (minus, size) = self.raw()?;
        if minus { self.range(0, i64::MAX) } else { Some(size) }
    }

    /// Notes the range that the present number violates.
    #[cold]
    #[inline(never)]
    fn set_range(&mut self, least: i64, most: i64) {
        self.range = Some((least, most));
    }

    /// Notes the range that the present number violates, and returns `None`.
    #[inline(always)] // // with a place for its result it would have too many arguments for a Mega
    pub fn range<T>(&mut self, least: i64, most: i64) -> Option<T> {
        self.set_range(least, most);
        None
    }

    /// The next number, from `least` to `most`.
    #[inline(never)]
    pub fn between(&mut self, least: u32, most: u32) -> Option<u32> {
        // Not by `next`: its frame would add to the deepest stack of a small chip.
        let (minus, size) = self.raw()?;
        match u32::try_from(size) {
            Ok(number) if !minus && (least..=most).contains(&number) => Some(number),
            _ => self.range(least.into(), most.into()),
        }
    }

    /// The next number, up to `most`.
    #[inline(never)]
    pub fn up_to(&mut self, most: u8) -> Option<u8> {
        self.between(0, most.into()).map(|number| number as u8)
    }

    /// The next number, 0 or 1.
    pub fn flag(&mut self) -> Option<bool> {
        self.up_to(1).map(|flag| flag != 0)
    }

    /// The next number, of 32 bits without a sign.
    #[inline(never)]
    pub fn word(&mut self) -> Option<u32> {
        self.between(0, u32::MAX)
    }

    /// The next number, of 32 bits with a sign.
    #[inline(never)]
    pub fn count(&mut self) -> Option<i32> {
        match i32::try_from(self.next()?) {
            Ok(count) => Some(count),
            Err(_) => self.range(i32::MIN.into(), i32::MAX.into()),
        }
    }

    /// Whether all numbers were read.
    pub fn is_end(&self) -> bool {
        self.rest.is_none()
    }

    /// The reason why the last number was not read.
    pub fn fault<R>(&self) -> Fault<R> {
        match self.range {
            Some((least, most)) => Fault::Range { number: self.read, least, most },
            None => Fault::Line,
        }
    }
}
