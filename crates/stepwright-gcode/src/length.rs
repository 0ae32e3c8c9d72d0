//! Lengths and positions in whole picometres.

use core::fmt;

use crate::decimal::{Decimal, fixed};

/// A length along an axis in whole picometres, from −10¹⁵ to 10¹⁵ (1 km each way). In a feed rate it is the
/// length per minute.
///
/// Exact for millimetres with nine digits after the point and for inches with eight. A [`Decimal`] with more
/// digits is rounded to the nearest picometre.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Length(i64);

impl Length {
    /// 0.
    pub const ZERO: Length = Length(0);
    /// The longest length, 1,000,000 mm. With the other sign it is the lowest.
    pub const MAX: Length = Length(1_000_000 * Self::PER_MM);
    /// Picometres per millimetre.
    pub const PER_MM: i64 = 1_000_000_000;

    /// A length in picometres; `None` beyond [`MAX`](Self::MAX) in either direction.
    pub const fn from_picometres(picometres: i64) -> Option<Length> {
        if picometres.unsigned_abs() <= Self::MAX.0 as u64 {
            Some(Length(picometres))
        } else {
            None
        }
    }

    /// The length in picometres.
    pub const fn picometres(self) -> i64 {
        self.0
    }

    /// The length of a number of inches or millimetres; `None` if it is beyond the range.
    pub(crate) fn of(number: Decimal, inches: bool) -> Option<Length> {
        // An inch is 25.4 mm, and a picometre is 100 units of the last digit of a decimal.
        let (times, over) = if inches { (254, 1000) } else { (1, 100) };
        let scaled = number.scaled().checked_mul(times)?;
        let half = if scaled < 0 { -over / 2 } else { over / 2 };
        Self::from_picometres((scaled + half) / over)
    }

    /// A sum of at most 1000 lengths; `None` if it is beyond the range.
    pub(crate) fn sum(terms: &[Length]) -> Option<Length> {
        Self::from_picometres(terms.iter().map(|term| term.0).sum())
    }
}

impl core::ops::Neg for Length {
    type Output = Length;

    fn neg(self) -> Length {
        Length(-self.0)
    }
}

/// Prints millimetres with all digits.
impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fixed(f, self.0, 9)
    }
}

/// A position of the machine, or an offset: X, Y and Z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Point(pub [Length; 3]);

impl Point {
    /// The machine's zero.
    pub const ZERO: Point = Point([Length::ZERO; 3]);
}

/// Prints `X1.5 Y0 Z-2`, in millimetres.
impl fmt::Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "X{x} Y{y} Z{z}")
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::string::ToString;

    use super::*;
    use crate::decimal::parse;

    #[test]
    fn millimetres_and_inches_are_exact_where_they_can_be() {
        for (text, inches, picometres) in [
            ("1", false, 1_000_000_000),
            ("-0.000000001", false, -1),
            ("0.0000000005", false, 1),
            ("-0.00000000049", false, 0),
            ("1", true, 25_400_000_000),
            ("-0.00000001", true, -254),
            ("0.12345678", true, 3_135_802_212),
            // 25.4 and 12.7 picometres.
            ("0.000000001", true, 25),
            ("-0.0000000005", true, -13),
            ("1000000", false, 1_000_000_000_000_000),
            ("39370.0787401574", true, 999_999_999_999_998),
        ] {
            let length = Length::of(parse(text).unwrap(), inches).map(Length::picometres);
            assert_eq!(length, Some(picometres), "{text} {inches}");
        }
    }

    #[test]
    fn beyond_a_kilometre_there_is_no_length() {
        for (text, inches) in [
            ("1000000.000000001", false),
            ("-9999999", false),
            ("39370.08", true),
            ("-9999999", true),
        ] {
            assert_eq!(Length::of(parse(text).unwrap(), inches), None, "{text} {inches}");
        }
        assert_eq!(Length::sum(&[Length::MAX, Length(1)]), None);
        assert_eq!(Length::sum(&[Length::MAX, Length(1), Length(-1)]), Some(Length::MAX));
    }

    #[test]
    fn a_point_prints_all_its_digits() {
        let point = Point([Length(1_500_000_000), Length(0), Length(-1)]);
        assert_eq!(point.to_string(), "X1.5 Y0 Z-0.000000001");
    }
}
