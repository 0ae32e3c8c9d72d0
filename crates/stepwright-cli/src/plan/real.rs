//! Real numbers as unevaluated sums of two `f64`: 104 bits and more.
//!
//! For the ideal that emitted delays are measured against: a travel may last
//! 2⁶² ticks, where an `f64` is 512 ticks coarse.
//!
//! The error-free sum is Knuth's, the product Dekker's; each operation is good
//! to a few 2⁻¹⁰⁴ of its result. Dekker's splitting rather than a fused
//! multiply-add, which is a slow library call on some machines.

use std::ops::{Add, Div, Mul, Sub};

/// `high + low`, with |low| at most half a unit of high's last place.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Real {
    high: f64,
    low: f64,
}

/// a + b and what rounding lost of it.
fn sum(a: f64, b: f64) -> Real {
    let high = a + b;
    let back = high - a;
    Real { high, low: (a - (high - back)) + (b - back) }
}

/// The same for |a| ≥ |b|.
fn quick_sum(a: f64, b: f64) -> Real {
    let high = a + b;
    Real { high, low: b - (high - a) }
}

/// a · b and what rounding lost of it.
fn product(a: f64, b: f64) -> Real {
    fn split(a: f64) -> (f64, f64) {
        let big = 134_217_729.0 * a; // 2²⁷ + 1
        let high = big - (big - a);
        (high, a - high)
    }
    let high = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    Real { high, low: ((ah * bh - high) + ah * bl + al * bh) + al * bl }
}

impl Real {
    /// Nothing.
    pub const ZERO: Real = Real { high: 0.0, low: 0.0 };

    /// The square root; 0 for what is below.
    pub fn sqrt(self) -> Real {
        if self.high <= 0.0 {
            return Real::ZERO;
        }
        // One Newton step from the hardware's root.
        let root = self.high.sqrt();
        let rest = self - product(root, root);
        quick_sum(root, rest.high / (2.0 * root))
    }

    /// The nearest `f64`.
    pub fn to_f64(self) -> f64 {
        self.high
    }
}

impl From<u64> for Real {
    fn from(n: u64) -> Real {
        sum((n >> 32 << 32) as f64, (n & 0xFFFF_FFFF) as f64)
    }
}

impl From<u32> for Real {
    fn from(n: u32) -> Real {
        Real { high: n.into(), low: 0.0 }
    }
}

impl From<f64> for Real {
    fn from(x: f64) -> Real {
        Real { high: x, low: 0.0 }
    }
}

impl Add for Real {
    type Output = Real;
    fn add(self, other: Real) -> Real {
        let (s, t) = (sum(self.high, other.high), sum(self.low, other.low));
        let s = quick_sum(s.high, s.low + t.high);
        quick_sum(s.high, s.low + t.low)
    }
}

impl Sub for Real {
    type Output = Real;
    fn sub(self, other: Real) -> Real {
        self + Real { high: -other.high, low: -other.low }
    }
}

impl Mul for Real {
    type Output = Real;
    fn mul(self, other: Real) -> Real {
        let p = product(self.high, other.high);
        quick_sum(p.high, p.low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Real {
    type Output = Real;
    fn div(self, other: Real) -> Real {
        // Long division with digits of 53 bits.
        let first = self.high / other.high;
        let rest = self - other * Real { high: first, low: 0.0 };
        let second = rest.high / other.high;
        let rest = rest - other * Real { high: second, low: 0.0 };
        let third = rest.high / other.high;
        let q = quick_sum(first, second);
        q + Real { high: third, low: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// x as an integer, when it is one below 2¹⁰⁶.
    fn whole(x: Real) -> i128 {
        x.high as i128 + x.low as i128
    }

    proptest! {
        #[test]
        fn sums_and_products_of_integers_are_exact(a in 0u64..1 << 52, b in 0u64..1 << 52) {
            let (x, y) = (Real::from(a), Real::from(b));
            prop_assert_eq!(whole(x + y), i128::from(a) + i128::from(b));
            prop_assert_eq!(whole(x - y), i128::from(a) - i128::from(b));
            prop_assert_eq!(whole(x * y), i128::from(a) * i128::from(b));
        }

        #[test]
        fn quotients_and_roots_lead_back(a: u64, b in 1u64..) {
            let (x, y) = (Real::from(a), Real::from(b));
            let off = ((x / y) * y - x).to_f64().abs();
            prop_assert!(off <= x.to_f64() * 2f64.powi(-100), "{off}");
            let root = x.sqrt();
            let off = (root * root - x).to_f64().abs();
            prop_assert!(off <= x.to_f64() * 2f64.powi(-100), "{off}");
        }

        #[test]
        fn every_u64_is_held(n: u64) {
            prop_assert_eq!(whole(Real::from(n)), i128::from(n));
        }
    }
}
