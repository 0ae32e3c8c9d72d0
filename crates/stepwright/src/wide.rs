//! Numbers with 64 significant bits and a sign, for curves on a host.
//!
//! A number is ± m · 2^e with 2⁶³ ≤ m < 2⁶⁴, or 0: like [`Num`](crate::num::Num) with twice the
//! bits and a sign. Integer arithmetic only, so every machine computes the same bits.
//!
//! ```text
//! error of a sum, a difference, a product   2⁻⁶⁴ of its result
//!          a quotient, a root               2⁻⁶³
//! ```
//!
//! Products and roots take 128 bits; a quotient is the slowest, some 20 ns on a PC.

use core::cmp::Ordering;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// A number with 64 significant bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Wide {
    /// The highest bit is set, except for 0.
    m: u64,
    e: i32,
    minus: bool,
}

impl Wide {
    pub(crate) const ZERO: Wide = Wide { m: 0, e: 0, minus: false };
    /// Larger than any number in use.
    pub(crate) const HUGE: Wide = Wide { m: 1 << 63, e: 1 << 20, minus: false };

    /// 1/3.
    pub(crate) const THIRD: Wide = Wide { m: 0xAAAA_AAAA_AAAA_AAAB, e: -65, minus: false };

    /// An integer, exactly.
    pub(crate) const fn whole(n: u64) -> Wide {
        if n == 0 {
            return Wide::ZERO;
        }
        let up = n.leading_zeros();
        Wide { m: n << up, e: -(up as i32), minus: false }
    }

    /// An integer with a sign, exactly.
    pub(crate) const fn signed(n: i64) -> Wide {
        let mut x = Wide::whole(n.unsigned_abs());
        x.minus = n < 0;
        x
    }

    /// The nearest to `wide` · 2^e.
    fn rounded(wide: u128, e: i32, minus: bool) -> Wide {
        if wide == 0 {
            return Wide::ZERO;
        }
        let up = wide.leading_zeros();
        let wide = wide << up;
        let (high, half) = ((wide >> 64) as u64, (wide >> 63) as u64 & 1);
        let e = e.saturating_add(64 - up as i32);
        match high.checked_add(half) {
            Some(m) => Wide { m, e, minus },
            None => Wide { m: 1 << 63, e: e.saturating_add(1), minus },
        }
    }

    pub(crate) const fn is_zero(self) -> bool {
        self.m == 0
    }

    /// Whether it is less than 0.
    pub(crate) const fn is_minus(self) -> bool {
        self.minus
    }

    /// Whether it is more than 0.
    pub(crate) const fn is_plus(self) -> bool {
        self.m != 0 && !self.minus
    }

    pub(crate) const fn abs(self) -> Wide {
        Wide { minus: false, ..self }
    }

    /// With the other sign if `other`.
    pub(crate) const fn flipped(self, other: bool) -> Wide {
        Wide { minus: self.m != 0 && self.minus != other, ..self }
    }

    /// · 2^by.
    pub(crate) const fn scaled(self, by: i32) -> Wide {
        if self.m == 0 { self } else { Wide { e: self.e.saturating_add(by), ..self } }
    }

    pub(crate) fn squared(self) -> Wide {
        self * self
    }

    /// √x; 0 if x is below 0.
    pub(crate) fn sqrt(self) -> Wide {
        if !self.is_plus() {
            return Wide::ZERO;
        }
        let odd = self.e & 1;
        // m · 2^e = (m · 2^(63 + odd)) · 2^(e − 63 − odd), an even exponent.
        let odd = odd ^ 1;
        let wide = u128::from(self.m) << (63 + odd);
        Wide::rounded(wide.isqrt(), (self.e - 63 - odd) / 2, false)
    }

    /// A power of two that is at least the cube root, at most 4 times it.
    pub(crate) fn above_cube_root(self) -> Wide {
        if self.m == 0 {
            self
        } else {
            Wide { m: 1 << 63, e: (self.e + 66).div_euclid(3) - 63, minus: false }
        }
    }

    /// In 2⁻³², rounded to nearest; 0 if below 0, saturating.
    pub(crate) fn to_q32(self) -> u128 {
        let by = self.e + 32;
        match by {
            _ if self.minus || self.m == 0 || by < -64 => 0,
            64.. => u128::MAX,
            0.. => u128::from(self.m) << by,
            _ => (u128::from(self.m) + (1 << (-by - 1))) >> -by,
        }
    }

    /// The largest whole number not above this; saturating.
    pub(crate) fn floor(self) -> i64 {
        let most = i64::MAX;
        let m = match self.e {
            _ if self.m == 0 => 0,
            0.. => most as u64,
            -63.. => self.m >> -self.e,
            _ => 0,
        };
        let whole = i64::try_from(m).unwrap_or(most);
        match self.minus {
            false => whole,
            true if Wide::whole(m) == self.abs() => -whole,
            true => (-whole).saturating_sub(1),
        }
    }

    /// The smallest whole number not below this; saturating.
    pub(crate) fn ceil(self) -> i64 {
        (-self).floor().saturating_neg()
    }
}

impl Neg for Wide {
    type Output = Wide;
    fn neg(self) -> Wide {
        self.flipped(true)
    }
}

impl Add for Wide {
    type Output = Wide;
    fn add(self, other: Wide) -> Wide {
        let (x, y) = if self.abs() >= other.abs() { (self, other) } else { (other, self) };
        let apart = x.e.saturating_sub(y.e);
        if y.m == 0 || apart > 66 {
            return x;
        }
        let (big, small) = (u128::from(x.m) << 63, (u128::from(y.m) << 63) >> apart);
        let sum = if x.minus == y.minus { big + small } else { big - small };
        Wide::rounded(sum, x.e.saturating_sub(63), x.minus)
    }
}

impl Sub for Wide {
    type Output = Wide;
    fn sub(self, other: Wide) -> Wide {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Wide;
    fn mul(self, other: Wide) -> Wide {
        let product = u128::from(self.m) * u128::from(other.m);
        Wide::rounded(product, self.e.saturating_add(other.e), self.minus != other.minus)
    }
}

/// Division by 0 gives [`Wide::HUGE`].
impl Div for Wide {
    type Output = Wide;
    fn div(self, other: Wide) -> Wide {
        let minus = self.minus != other.minus;
        let Some(quotient) = (u128::from(self.m) << 64).checked_div(other.m.into()) else {
            return Wide::HUGE.flipped(self.minus);
        };
        Wide::rounded(quotient, self.e.saturating_sub(other.e).saturating_sub(64), minus)
    }
}

impl Ord for Wide {
    fn cmp(&self, other: &Wide) -> Ordering {
        let size = |x: &Wide| (x.m != 0, x.e, x.m);
        match (self.minus, other.minus) {
            (false, false) => size(self).cmp(&size(other)),
            (true, true) => size(other).cmp(&size(self)),
            (true, false) => Ordering::Less,
            (false, true) => Ordering::Greater,
        }
    }
}

impl PartialOrd for Wide {
    fn partial_cmp(&self, other: &Wide) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dashu_float::{FBig, round::mode::HalfEven};
    use proptest::prelude::*;

    type Real = FBig<HalfEven, 2>;

    fn wide() -> impl Strategy<Value = Wide> {
        let some = (any::<u64>(), -90i32..90, any::<bool>())
            .prop_map(|(m, e, minus)| Wide::whole(m).scaled(e).flipped(minus));
        prop_oneof![20 => some, 1 => Just(Wide::ZERO)]
    }

    fn real(x: Wide) -> Real {
        let m = Real::from(x.m).with_precision(300).value();
        let m = if x.minus { -m } else { m };
        m * Real::from(2).with_precision(300).value().powi(x.e.into())
    }

    /// Within 2^−bits of `want`.
    fn near(got: Wide, want: Real, bits: i32) -> bool {
        let off = real(got) - &want;
        let scale = real(Wide::whole(1).scaled(-bits));
        off.clone() * &off <= &want * &want * &scale * &scale
    }

    proptest! {
        #[test]
        fn operations_are_good_to_their_last_place(a in wide(), b in wide()) {
            prop_assert!(near(a + b, real(a) + real(b), 64));
            prop_assert!(near(a - b, real(a) - real(b), 64));
            prop_assert!(near(a * b, real(a) * real(b), 64));
            if !b.is_zero() {
                prop_assert!(near(a / b, real(a) / real(b), 63));
            }
            if !a.is_minus() {
                prop_assert!(near(a.sqrt(), real(a).sqrt(), 62));
            }
            prop_assert_eq!(a.cmp(&b), real(a).partial_cmp(&real(b)).unwrap());
        }

        #[test]
        fn cube_roots_are_bounded(a in wide()) {
            let a = a.abs();
            let up = a.above_cube_root();
            prop_assert!(up * up * up >= a);
            prop_assert!((up * up * up).scaled(-6) <= a);
        }

        #[test]
        fn whole_numbers_stay(n: i64, m in 0u64..1 << 31, part: u32) {
            prop_assert_eq!(Wide::signed(n).floor(), n.max(-i64::MAX));
            prop_assert_eq!(Wide::signed(n).ceil(), n.max(-i64::MAX));
            let x = Wide::whole(m << 20) + Wide::whole(part.into()).scaled(-12);
            let whole = (m << 20) as i64 + i64::from(part >> 12);
            let up = whole + i64::from(part % 4096 != 0);
            prop_assert_eq!((x.floor(), x.ceil()), (whole, up));
            prop_assert_eq!(((-x).floor(), (-x).ceil()), (-up, -whole));
            prop_assert_eq!(x.to_q32(), (u128::from(m) << 52) + (u128::from(part) << 20));
        }
    }

    #[test]
    fn nothing_is_beyond_huge() {
        assert_eq!(Wide::whole(7) / Wide::ZERO, Wide::HUGE);
        assert!(Wide::HUGE > Wide::whole(u64::MAX) * Wide::whole(u64::MAX));
        assert_eq!(Wide::HUGE.to_q32(), u128::MAX);
        assert_eq!(Wide::HUGE.floor(), i64::MAX);
        assert_eq!(Wide::whole(1).scaled(-200).to_q32(), 0);
    }
}
