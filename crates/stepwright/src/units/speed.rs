//! Speed and acceleration along one axis, in thousandths of a step.

use crate::num::{Num, whole};
use core::fmt;

/// A value out of range: the quantity and the allowed range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutOfRange {
    /// The quantity, as a user calls it: "top speed", "timer rate".
    pub what: &'static str,
    /// The smallest allowed value, in `unit`.
    pub min: u64,
    /// The largest allowed value, in `unit`.
    pub max: u64,
    /// The unit of `min` and `max`.
    pub unit: &'static str,
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} out of range: {} to {} {}", self.what, self.min, self.max, self.unit)
    }
}

impl core::error::Error for OutOfRange {}

/// A speed without a sign: 0 … 1,000,000 steps/s, held in 0.001 steps/s.
///
/// ```
/// use stepwright::Speed;
/// let v = Speed::from_steps(1000).unwrap();
/// assert_eq!(v.millisteps(), 1_000_000);
/// assert_eq!(v.to_string(), "1000");
/// assert_eq!(Speed::from_millisteps(2_500).unwrap().to_string(), "2.5");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Speed(u32);

impl Speed {
    /// Standstill.
    pub const ZERO: Speed = Speed(0);
    /// 1,000,000 steps/s.
    pub const MAX: Speed = Speed(1_000_000_000);

    /// A speed in whole steps per second, as a compile-time constant. A speed above 1,000,000 does
    /// not compile.
    ///
    /// ```
    /// use stepwright::Speed;
    /// const LIMIT: Speed = Speed::of::<4_000>();
    /// assert_eq!(Ok(LIMIT), Speed::from_steps(4_000));
    /// ```
    ///
    /// ```compile_fail
    /// let speed = stepwright::Speed::of::<1_000_001>();
    /// ```
    pub const fn of<const STEPS_PER_SECOND: u32>() -> Speed {
        const { assert!(STEPS_PER_SECOND <= 1_000_000, "a speed is 0 to 1,000,000 steps/s") };
        Speed(STEPS_PER_SECOND.wrapping_mul(1000))
    }

    /// A speed in whole steps per second.
    ///
    /// # Errors
    /// [`OutOfRange`] above 1,000,000 steps/s.
    pub const fn from_steps(steps_per_second: u32) -> Result<Speed, OutOfRange> {
        match steps_per_second.checked_mul(1000) {
            Some(v) => Speed::from_millisteps(v),
            None => Err(Speed::RANGE),
        }
    }

    /// A speed in thousandths of a step per second.
    ///
    /// # Errors
    /// [`OutOfRange`] above 1,000,000 steps/s.
    pub const fn from_millisteps(v: u32) -> Result<Speed, OutOfRange> {
        if v > Speed::MAX.0 { Err(Speed::RANGE) } else { Ok(Speed(v)) }
    }

    const RANGE: OutOfRange = OutOfRange { what: "speed", min: 0, max: 1_000_000, unit: "steps/s" };

    /// Thousandths of a step per second.
    pub const fn millisteps(self) -> u32 {
        self.0
    }

    /// Whole steps per second, rounded down.
    pub fn steps(self) -> u32 {
        // A 32-bit quotient is exact enough: thousandths are further apart. (An 8-bit chip has this
        // division already, and no other.)
        whole(self.0).over(&const { Num::and_inverse(1000).0 }).split().0
    }

    /// v², in 10⁻⁶ (steps/s)²: at most 10¹⁸, exact.
    pub const fn squared(self) -> u64 {
        self.0 as u64 * self.0 as u64
    }
}

/// An acceleration without a sign: 0.001 … 100,000,000 steps/s², held in
/// 0.001 steps/s².
///
/// ```
/// use stepwright::Accel;
/// assert_eq!(Accel::from_steps(40_000).unwrap().to_string(), "40000");
/// assert!(Accel::from_steps(0).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Accel(u64);

impl Accel {
    /// 100,000,000 steps/s².
    pub const MAX: Accel = Accel(100_000_000_000);
    /// 0.001 steps/s².
    pub const MIN: Accel = Accel(1);

    /// An acceleration in whole steps per second squared, as a compile-time constant: 1 to
    /// 100,000,000. Any other value does not compile.
    ///
    /// ```
    /// use stepwright::Accel;
    /// const LIMIT: Accel = Accel::of::<10_000>();
    /// assert_eq!(Ok(LIMIT), Accel::from_steps(10_000));
    /// ```
    ///
    /// ```compile_fail
    /// let acceleration = stepwright::Accel::of::<0>();
    /// ```
    pub const fn of<const STEPS_PER_SECOND_2: u32>() -> Accel {
        const {
            let fits = STEPS_PER_SECOND_2 >= 1 && STEPS_PER_SECOND_2 <= 100_000_000;
            assert!(fits, "an acceleration is 1 to 100,000,000 steps/s²");
        }
        Accel(const { STEPS_PER_SECOND_2 as u64 * 1000 })
    }

    /// An acceleration in whole steps per second squared.
    ///
    /// # Errors
    /// [`OutOfRange`] unless 1 ≤ `a` ≤ 100,000,000.
    pub const fn from_steps(a: u32) -> Result<Accel, OutOfRange> {
        Accel::from_millisteps(a as u64 * 1000)
    }

    /// The acceleration nearest to `a` steps/s² that is allowed: 1 … 100,000,000.
    pub const fn clamped(a: u32) -> Accel {
        let most = 100_000_000;
        let a = if a > most { most } else { a };
        Accel(times_1000(if a == 0 { 1 } else { a }))
    }

    /// An acceleration in thousandths of a step per second squared.
    ///
    /// # Errors
    /// [`OutOfRange`] unless 1 ≤ `a` ≤ 10¹¹.
    pub const fn from_millisteps(a: u64) -> Result<Accel, OutOfRange> {
        if a == 0 || a > Accel::MAX.0 {
            return Err(OutOfRange {
                what: "acceleration",
                min: 0,
                max: 100_000_000,
                unit: "steps/s², and not 0",
            });
        }
        Ok(Accel(a))
    }

    /// Thousandths of a step per second squared.
    pub const fn millisteps(self) -> u64 {
        self.0
    }
}

/// Writes thousandths as a decimal without trailing zeros.
pub(super) fn thousandths(f: &mut fmt::Formatter<'_>, v: u64) -> fmt::Result {
    let (whole, part) = (v / 1000, v % 1000);
    if part == 0 {
        write!(f, "{whole}")
    } else if part % 100 == 0 {
        write!(f, "{whole}.{}", part / 100)
    } else if part % 10 == 0 {
        write!(f, "{whole}.{:02}", part / 10)
    } else {
        write!(f, "{whole}.{part:03}")
    }
}

impl fmt::Display for Speed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        thousandths(f, self.0.into())
    }
}

impl fmt::Display for Accel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        thousandths(f, self.0)
    }
}

/// 1000 · n, in two halves: a 64-bit product costs an 8-bit chip 1,100 cycles.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub(super) const fn times_1000(n: u32) -> u64 {
    let low = (n & 0xFFFF).wrapping_mul(1000);
    let high = (n >> 16).wrapping_mul(1000).wrapping_add(low >> 16);
    let ([c, d, e, f], [a, b, ..]) = (high.to_le_bytes(), low.to_le_bytes());
    u64::from_le_bytes([a, b, c, d, e, f, 0, 0])
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn the_nearest_acceleration_is_the_same_number() {
        for a in [1, 2, 65_535, 65_536, 65_537, 1_000_003, 99_999_999, 100_000_000] {
            assert_eq!(Accel::from_steps(a), Ok(Accel::clamped(a)));
        }
        assert_eq!((Accel::clamped(0).millisteps(), Accel::clamped(u32::MAX)), (1000, Accel::MAX));
    }

    #[test]
    fn edges_are_checked_once() {
        assert_eq!(Speed::from_steps(1_000_000), Ok(Speed::MAX));
        assert!(Speed::from_steps(1_000_001).is_err());
        assert!(Speed::from_steps(u32::MAX).is_err());
        assert!(Accel::from_millisteps(0).is_err());
        assert_eq!(Accel::from_steps(100_000_000), Ok(Accel::MAX));
        assert!(Accel::from_steps(100_000_001).is_err());
    }

    #[test]
    fn what_is_held_is_shown() {
        let v = |m| Speed::from_millisteps(m).unwrap().to_string();
        assert_eq!(
            [v(1), v(10), v(100), v(1000), v(1_234)],
            ["0.001", "0.01", "0.1", "1", "1.234"]
        );
    }

    #[test]
    fn an_error_says_what_is_allowed() {
        let e = Speed::from_steps(2_000_000).unwrap_err();
        assert_eq!(e.to_string(), "speed out of range: 0 to 1000000 steps/s");
    }
}
