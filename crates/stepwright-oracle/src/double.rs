//! Real numbers as unevaluated sums of two `f64`: 104 bits and more.
//!
//! For the ideal with which emitted delays are compared: a travel may last 2⁶² ticks, where the
//! resolution of an `f64` is 512 ticks.
//!
//! The error-free sum is Knuth's, the product Dekker's; each operation has a relative error of a
//! few 2⁻¹⁰⁴. Dekker's splitting is used instead of a fused multiply-add, which is a slow library
//! call on some machines.

use core::ops::{Add, Div, Mul, Sub};

use crate::Number;

/// A real number of 104 bits: `high + low`, with |low| at most half a unit of high's last place.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Double {
    high: f64,
    low: f64,
}

/// a + b and its rounding error.
fn sum(a: f64, b: f64) -> Double {
    let high = a + b;
    let back = high - a;
    Double { high, low: (a - (high - back)) + (b - back) }
}

/// [`sum`] for |a| ≥ |b|.
fn quick_sum(a: f64, b: f64) -> Double {
    let high = a + b;
    Double { high, low: b - (high - a) }
}

/// a · b and its rounding error.
fn product(a: f64, b: f64) -> Double {
    fn split(a: f64) -> (f64, f64) {
        let big = 134_217_729.0 * a; // 2²⁷ + 1
        let high = big - (big - a);
        (high, a - high)
    }
    let high = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    Double { high, low: ((ah * bh - high) + ah * bl + al * bh) + al * bl }
}

impl Number for Double {
    const ROUNDS: u32 = 2;

    fn whole(n: u64) -> Double {
        sum((n >> 32 << 32) as f64, (n & 0xFFFF_FFFF) as f64)
    }

    fn from_f64(x: f64) -> Double {
        Double { high: x, low: 0.0 }
    }

    fn to_f64(self) -> f64 {
        self.high
    }

    fn root(self) -> Double {
        if self.high <= 0.0 {
            return Double { high: 0.0, low: 0.0 };
        }
        // One Newton step from the hardware's root.
        let root = self.high.root();
        let rest = self - product(root, root);
        quick_sum(root, rest.high / (2.0 * root))
    }
}

impl Add for Double {
    type Output = Double;
    fn add(self, other: Double) -> Double {
        let (s, t) = (sum(self.high, other.high), sum(self.low, other.low));
        let s = quick_sum(s.high, s.low + t.high);
        quick_sum(s.high, s.low + t.low)
    }
}

impl Sub for Double {
    type Output = Double;
    fn sub(self, other: Double) -> Double {
        self + Double { high: -other.high, low: -other.low }
    }
}

impl Mul for Double {
    type Output = Double;
    fn mul(self, other: Double) -> Double {
        let p = product(self.high, other.high);
        quick_sum(p.high, p.low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Double {
    type Output = Double;
    fn div(self, other: Double) -> Double {
        // Long division with digits of 53 bits.
        let first = self.high / other.high;
        let rest = self - other * Double { high: first, low: 0.0 };
        let second = rest.high / other.high;
        let rest = rest - other * Double { high: second, low: 0.0 };
        let third = rest.high / other.high;
        let q = quick_sum(first, second);
        q + Double { high: third, low: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// x as an integer, if it is one below 2¹⁰⁶.
    fn whole(x: Double) -> i128 {
        x.high as i128 + x.low as i128
    }

    proptest! {
        #[test]
        fn sums_and_products_of_integers_are_exact(a in 0u64..1 << 52, b in 0u64..1 << 52) {
            let (x, y) = (Double::whole(a), Double::whole(b));
            prop_assert_eq!(whole(x + y), i128::from(a) + i128::from(b));
            prop_assert_eq!(whole(x - y), i128::from(a) - i128::from(b));
            prop_assert_eq!(whole(x * y), i128::from(a) * i128::from(b));
        }

        #[test]
        fn quotients_and_roots_lead_back(a: u64, b in 1u64..) {
            let (x, y) = (Double::whole(a), Double::whole(b));
            let off = ((x / y) * y - x).to_f64().abs();
            prop_assert!(off <= x.to_f64() * 2f64.powi(-100), "{off}");
            let root = x.root();
            let off = (root * root - x).to_f64().abs();
            prop_assert!(off <= x.to_f64() * 2f64.powi(-100), "{off}");
        }

        #[test]
        fn every_u64_is_held(n: u64) {
            prop_assert_eq!(whole(Double::whole(n)), i128::from(n));
        }
    }
}
