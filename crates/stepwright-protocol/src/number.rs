//! Numbers of a line: whole and decimal. The type guarantees the range.

use crate::flash::text;
use crate::grammar::{Argument, Shape};
use crate::raw_line::RawLine;
use crate::text::Piece;
use crate::{BadLine, Refusal};

/// A whole number from `MIN` to `MAX`, both included.
///
/// The bounds are checked where a number enters, from the line or from a program. A `Whole` need
/// not be checked again.
///
/// ```
/// use stepwright_protocol::RampSteps;
/// assert_eq!(RampSteps::new(200).unwrap().get(), 200);
/// assert!(RampSteps::new(0).is_none());
/// assert_eq!(RampSteps::clamped(5000), RampSteps::LARGEST);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Whole<const MIN: u32, const MAX: u32>(u32);

/// A speed in tens of steps per second, as S and T carry it: 1 … 999.
pub type Tens = Whole<1, 999>;
/// The length of a ramp in steps, as R carries it: 1 … 999.
pub type RampSteps = Whole<1, 999>;
/// A start speed in steps/s, as `s` carries it: 0 (from rest) … 1,000,000.
pub type StartSpeed = Whole<0, 1_000_000>;
/// A top speed in steps/s, as `t` carries it: 1 … 1,000,000.
pub type TopSpeed = Whole<1, 1_000_000>;
/// A top speed in 0.001 steps/s, as `m` carries it: 1 … 1,000,000,000.
pub type MilliSpeed = Whole<1, 1_000_000_000>;
/// An acceleration in steps/s², as `a` and `d` carry it: 1 … 100,000,000.
pub type WholeAccel = Whole<1, 100_000_000>;
/// A lease in ms, as `L` carries it: 0 (ends the lease) … 60,000.
pub type LeaseMillis = Whole<0, 60_000>;
/// A jerk in steps/s³, as `j` carries it: 0 (none) … 4,000,000,000.
pub type WholeJerk = Whole<0, 4_000_000_000>;

impl<const MIN: u32, const MAX: u32> Whole<MIN, MAX> {
    /// `MIN`, as a value of this type.
    pub const SMALLEST: Self = Whole(MIN);
    /// `MAX`, as a value of this type.
    pub const LARGEST: Self = Whole(MAX);

    /// `n`, or `None` when it is outside the range.
    pub const fn new(n: u32) -> Option<Self> {
        if n < MIN || n > MAX { None } else { Some(Whole(n)) }
    }

    /// The value of the range nearest to `n`.
    pub const fn clamped(n: u32) -> Self {
        if n < MIN {
            Whole(MIN)
        } else if n > MAX {
            Whole(MAX)
        } else {
            Whole(n)
        }
    }

    /// The number, in the unit of the type's name.
    pub const fn get(self) -> u32 {
        self.0
    }
}

/// A travel in steps relative to the last end position, + clockwise: all 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Distance(i32);

impl Distance {
    /// `steps`, + clockwise.
    ///
    /// ```
    /// use stepwright_protocol::Distance;
    /// assert_eq!(Distance::new(-4000).get(), -4000);
    /// ```
    pub const fn new(steps: i32) -> Distance {
        Distance(steps)
    }

    /// Steps, + clockwise.
    pub const fn get(self) -> i32 {
        self.0
    }
}

impl<const MIN: u32, const MAX: u32> Argument for Whole<MIN, MAX> {
    const SHAPE: Shape = Shape::number(MIN, MAX);

    fn of(raw: &RawLine) -> Option<Self> {
        Whole::new(raw.number)
    }

    fn piece(self, n: u8) -> Option<Piece> {
        (n == 0).then_some(Piece::Number(self.0))
    }
}

impl Argument for Distance {
    const SHAPE: Shape = Shape::signed(i32::MAX as u32);

    fn of(raw: &RawLine) -> Option<Distance> {
        Some(Distance::new(raw.steps()))
    }

    fn piece(self, n: u8) -> Option<Piece> {
        match n {
            0 => Some(sign(self.0 < 0)),
            1 => Some(Piece::Number(self.0.unsigned_abs())),
            _ => None,
        }
    }
}

impl Argument for Direction {
    const SHAPE: Shape = Shape::SIGN;

    fn of(raw: &RawLine) -> Option<Direction> {
        Some(if raw.backward { Direction::Backward } else { Direction::Forward })
    }

    fn piece(self, n: u8) -> Option<Piece> {
        (n == 0).then_some(sign(self == Direction::Backward))
    }
}

fn sign(backward: bool) -> Piece {
    Piece::Text(if backward { text!("-") } else { text!("+") })
}

/// The direction in which the shaft turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// `+`, clockwise, positions grow.
    Forward,
    /// `-`, counter-clockwise.
    Backward,
}

/// Reads one or more decimal digits and nothing else. Leading zeros are allowed.
///
/// The whole text is checked even after an overflow, so that `9999999999x` is unknown, as `9x` is.
pub(crate) fn digits(text: &[u8]) -> Result<u32, BadLine> {
    let mut number = 0;
    match read(text, &mut number) {
        Ok(()) => Ok(number),
        Err(Refusal::Range) => Err(BadLine::Range),
        Err(_) => Err(BadLine::Unknown),
    }
}

/// Like [`digits`], in place. Fails with [`Refusal::Line`] or [`Refusal::Range`].
#[inline(never)]
pub(crate) fn read(text: &[u8], number: &mut u32) -> Result<(), Refusal> {
    let (mut value, mut fits) = (0u32, true);
    for byte in text {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return Err(Refusal::Line);
        }
        // An overflow is either far too large, so that the high byte is at least 26, or it wraps to
        // a smaller value. The test of one byte is short.
        let [.., high] = value.to_le_bytes();
        let next = value.wrapping_mul(10).wrapping_add(digit.into());
        fits &= high < 26 && next >= value;
        value = next;
    }
    *number = value;
    match (text.is_empty(), fits) {
        (true, _) => Err(Refusal::Line),
        (_, false) => Err(Refusal::Range),
        _ => Ok(()),
    }
}

/// Splits at the first `at`.
pub(crate) fn halves(text: &[u8], at: u8) -> Option<(&[u8], &[u8])> {
    let mut halves = text.splitn(2, |byte| *byte == at);
    Some((halves.next()?, halves.next()?))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    #[test]
    fn bounds_belong_to_the_range() {
        assert!(Tens::new(0).is_none() && Tens::new(1000).is_none());
        assert!(Tens::new(1).is_some() && Tens::new(999).is_some());
        assert_eq!(StartSpeed::new(0), Some(StartSpeed::SMALLEST));
        assert_eq!(WholeAccel::clamped(0).get(), 1);
    }

    #[test]
    fn digits_are_read_to_the_end() {
        assert_eq!(digits(b"4294967295"), Ok(u32::MAX));
        assert_eq!(digits(b"4294967296"), Err(BadLine::Range));
        assert_eq!(digits(b"9999999999"), Err(BadLine::Range));
        for tenth in [429_496_729u64, 429_496_730, 436_207_615, 436_207_616, 999_999_999] {
            for digit in 0..10 {
                let text = std::format!("{tenth}{digit}");
                let exact = text.parse::<u32>().map_err(|_| BadLine::Range);
                assert_eq!(digits(text.as_bytes()), exact, "{text}");
            }
        }
        assert_eq!(digits(b"00000000000007"), Ok(7));
        for unknown in
            [&b""[..], b"x", b"1x", b"9999999999x", b"+1", b" 1", b"1 ", b"\xb1", b":", b"/"]
        {
            assert_eq!(digits(unknown), Err(BadLine::Unknown), "{unknown:?}");
        }
    }
}
