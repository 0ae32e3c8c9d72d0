//! The numbers of a line.

use super::Fault;

/// Decimal numbers with commas between them, read one by one, each checked for its range.
///
/// ```
/// use stepwright_protocol::{Fault, Numbers};
/// let mut numbers = Numbers::of(b"-4000,7");
/// assert_eq!((numbers.next(), numbers.between(1, 5)), (Some(-4_000), None));
/// assert_eq!(numbers.fault::<()>(), Fault::Range { number: 2, least: 1, most: 5 });
/// ```
pub struct Numbers<'t> {
    /// What is left; `None` behind the last one.
    rest: Option<&'t [u8]>,
    /// How many were read.
    read: u8,
    /// What the one that was not may be: here, and not in each result, of which a small chip
    /// would copy it.
    range: Option<(i64, i64)>,
}

impl<'t> Numbers<'t> {
    /// Those of a text; of an empty one none.
    pub fn of(text: &'t [u8]) -> Numbers<'t> {
        Numbers { rest: (!text.is_empty()).then_some(text), read: 0, range: None }
    }

    /// Whether the next one is below 0, and its size; `None` if it is none, or has more than 64 bits.
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
            // Far too large at once, and wrapped by less than a tenth if just so: the test of
            // one byte is short.
            let [.., high] = value.to_le_bytes();
            let next = (value << 3).wrapping_add(value << 1).wrapping_add(digit.into());
            if digit > 9 || high >= 26 || next < value {
                return None;
            }
            (value, empty) = (next, false);
        }
        (!empty).then_some((minus && value != 0, value))
    }

    /// The next one, of 63 bits and a sign.
    #[inline(never)]
    #[allow(clippy::should_implement_trait, reason = "a number that is none ends no iterator")]
    pub fn next(&mut self) -> Option<i64> {
        let (minus, size) = self.raw()?;
        match i64::try_from(size) {
            Ok(number) => Some(if minus { number.wrapping_neg() } else { number }),
            Err(_) => self.range(-i64::MAX, i64::MAX),
        }
    }

    /// The next one, of 64 bits without a sign.
    #[inline(never)]
    pub fn wide(&mut self) -> Option<u64> {
        let (minus, size) = self.raw()?;
        if minus { self.range(0, i64::MAX) } else { Some(size) }
    }

    /// The present number is out of its range.
    #[cold]
    #[inline(never)]
    fn set_range(&mut self, least: i64, most: i64) {
        self.range = Some((least, most));
    }

    /// The present number is out of this range: the answer to whoever asked for it.
    #[inline(always)] // with the place of its result it would have too many arguments for a Mega
    pub fn range<T>(&mut self, least: i64, most: i64) -> Option<T> {
        self.set_range(least, most);
        None
    }

    /// The next one, from `least` to `most`.
    #[inline(never)]
    pub fn between(&mut self, least: u32, most: u32) -> Option<u32> {
        // Not by `next`, whose frame would lie on the deepest stack of a small chip.
        let (minus, size) = self.raw()?;
        match u32::try_from(size) {
            Ok(number) if !minus && (least..=most).contains(&number) => Some(number),
            _ => self.range(least.into(), most.into()),
        }
    }

    /// The next one, up to `most`.
    #[inline(never)]
    pub fn up_to(&mut self, most: u8) -> Option<u8> {
        self.between(0, most.into()).map(|number| number as u8)
    }

    /// The next one, 0 or 1.
    pub fn flag(&mut self) -> Option<bool> {
        self.up_to(1).map(|flag| flag != 0)
    }

    /// The next one, of 32 bits without a sign.
    #[inline(never)]
    pub fn word(&mut self) -> Option<u32> {
        self.between(0, u32::MAX)
    }

    /// The next one, of 32 bits with a sign.
    #[inline(never)]
    pub fn count(&mut self) -> Option<i32> {
        match i32::try_from(self.next()?) {
            Ok(count) => Some(count),
            Err(_) => self.range(i32::MIN.into(), i32::MAX.into()),
        }
    }

    /// Whether there are no more.
    pub fn is_end(&self) -> bool {
        self.rest.is_none()
    }

    /// Why the last one was not read.
    pub fn fault<R>(&self) -> Fault<R> {
        match self.range {
            Some((least, most)) => Fault::Range { number: self.read, least, most },
            None => Fault::Line,
        }
    }
}
