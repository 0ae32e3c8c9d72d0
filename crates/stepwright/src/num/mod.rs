//! Numbers with 32 significant bits, for planning on a small chip.
//!
//! A number is m · 2^e with 2³¹ ≤ m < 2³², or 0: floating point in integer arithmetic, so that a PC
//! and an 8-bit chip compute the same bits. No number is negative; a difference that would be
//! negative is 0.
//!
//! ```text
//! error of each operation: less than 2⁻³⁰ of its result, mostly 2⁻³¹
//! ```
//!
//! For an 8-bit chip all functions are out of line and use 32-bit steps: 64-bit arithmetic costs it
//! a hundred bytes of flash wherever it appears.

#[cfg(feature = "external-numbers")]
mod external;
mod hand;

#[cfg(feature = "external-numbers")]
pub use external::layout;
pub(crate) use hand::{Hand, hand, part, whole};

/// A number ≥ 0 with 32 significant bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)] // the assembly reads it
pub(crate) struct Num {
    /// m, in two halves: so a compiler for 8 bits passes a number by its address, which takes a
    /// third of the code.
    low: u16,
    high: u16,
    e: i16,
}

impl Num {
    /// The exponent is below every other: zero is never the larger of two numbers.
    #[cfg(not(feature = "external-numbers"))]
    pub(crate) const ZERO: Num = Num::of(0, i16::MIN / 2);
    /// The initial value of a number that is set before it is read.
    pub(crate) const UNSET: Num = Num::of(0, 0);
    #[cfg(test)]
    pub(crate) const ONE: Num = Num::power(0);

    /// 2^e.
    pub(crate) const fn power(e: i16) -> Num {
        Num::of(1 << 31, e - 31)
    }

    /// The upper 32 bits of an integer ≥ 1, and its inverse: for constants, with arithmetic that a
    /// small chip does not have.
    #[inline(always)]
    pub(crate) const fn and_inverse(x: u64) -> (Num, Num) {
        let x = if x == 0 { 1 } else { x };
        let e = 32 - x.leading_zeros() as i16;
        let m = if e > 0 { x >> e } else { x << -e } as u32;
        let inverse = if m == 1 << 31 {
            Num::of(m, -62 - e)
        } else {
            Num::of(((1 << 63) / m as u64) as u32, -63 - e)
        };
        (Num::of(m, e), inverse)
    }

    pub(crate) const fn is_zero(&self) -> bool {
        self.m() == 0
    }

    #[inline(always)]
    const fn of(m: u32, e: i16) -> Num {
        Num { high: (m >> 16) as u16, low: m as u16, e }
    }

    #[inline(always)]
    const fn m(&self) -> u32 {
        (self.high as u32) << 16 | self.low as u32
    }

    /// Sets this number to the upper 32 bits of an integer.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn set_wide(&mut self, x: u64) {
        // The sum of the two halves: exact up to 32 bits, else rounded down.
        whole(x as u32).to(self);
        whole((x >> 32) as u32).scaled(32).plus(self).to(self);
    }

    /// A power of two near the cube root, for small exponents.
    pub(crate) fn near_cube_root(&self) -> Num {
        // A third is 85 / 256.
        Num::power(self.exponent().wrapping_mul(85) >> 8)
    }

    /// The largest n for which the number is at least 2^n.
    pub(crate) fn exponent(&self) -> i16 {
        self.e.wrapping_add(31)
    }

    /// What the number has beyond 2^[`exponent`](Num::exponent), as a fraction of that, in 1/256,
    /// rounded down.
    pub(crate) fn fraction(&self) -> u8 {
        (self.high >> 7) as u8
    }

    /// Sets this number to `to` if that is between `least` and `most`; else to `least` plus `part`
    /// of the way to `most`.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn set_between(&mut self, least: &Num, to: &Num, most: &Num, part: &Num) {
        let inside = !least.at_least(to) && !to.at_least(most);
        if inside {
            self.set(to);
        } else {
            hand(most).minus(least).times(part).plus(least).to(self);
        }
    }

    /// The least e for which the number is less than 2^e.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn bits(&self) -> i16 {
        if self.high == 0 { i16::MIN / 2 } else { self.e.wrapping_add(32) }
    }

    /// · 2^by.
    pub(crate) fn scaled(&self, by: i16) -> Num {
        Num::of(self.m(), self.e.wrapping_add(by))
    }
}

/// The operations, unless a board-support crate provides them.
#[cfg(not(feature = "external-numbers"))]
impl Num {
    /// m · 2^e, for any m.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn new(mut m: u32, mut e: i16) -> Num {
        if m == 0 {
            return Num::ZERO;
        }
        // Whole bytes first: an 8-bit chip moves them.
        while m >> 24 == 0 {
            m <<= 8;
            e = e.wrapping_sub(8);
        }
        while m >> 31 == 0 {
            m <<= 1;
            e = e.wrapping_sub(1);
        }
        Num::of(m, e)
    }

    /// Sets this number to another.
    #[inline(always)]
    pub(crate) fn set(&mut self, to: &Num) {
        *self = *to;
    }

    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn plus(&self, other: &Num) -> Num {
        let (a, b) = if self.e >= other.e { (self, other) } else { (other, self) };
        let b_m = shifted_down(b.m(), a.e.wrapping_sub(b.e));
        let (m, carry) = a.m().overflowing_add(b_m);
        if carry { Num::of(m >> 1 | 1 << 31, a.e.wrapping_add(1)) } else { Num::of(m, a.e) }
    }

    /// The difference; 0 if it would be negative.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn minus(&self, other: &Num) -> Num {
        if self.e < other.e {
            return Num::ZERO;
        }
        // The bits dropped below would make the result smaller by less than a unit.
        let other = shifted_down(other.m(), self.e.wrapping_sub(other.e));
        match self.m().overflowing_sub(other) {
            (_, true) => Num::ZERO,
            (m, false) => Num::new(m, self.e),
        }
    }

    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn at_least(&self, other: &Num) -> bool {
        if self.e != other.e { self.e > other.e } else { self.m() >= other.m() }
    }

    /// The largest n for which x · 2^n is not more than this number. Neither number may be 0, and
    /// they must be less than a factor of 2¹²⁸ apart.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn doublings_of(&self, x: &Num) -> i8 {
        self.e.wrapping_sub(x.e).wrapping_sub((self.m() < x.m()).into()) as i8
    }

    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn times(&self, other: &Num) -> Num {
        Num::product(high_product(self.m(), other.m()), self.e, other.e)
    }

    /// The product to 15 bits: a quarter of the time on an 8-bit chip.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn roughly(&self, other: &Num) -> Num {
        Num::product(short_product(self.high, other.high), self.e, other.e)
    }

    /// The quotient; the quotient by 0 is larger than any number in use.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn over(&self, other: &Num) -> Num {
        if self.m() == 0 {
            return Num::ZERO;
        }
        if other.m() == 0 {
            return Num::of(u32::MAX, i16::MAX / 4);
        }
        let e = self.e.wrapping_sub(other.e);
        // Both mantissas have their top bit set: the quotient is ½ … 2.
        if self.m() >= other.m() {
            let m = fraction(self.m().wrapping_sub(other.m()), other.m());
            Num::of(m >> 1 | 1 << 31, e.wrapping_sub(31))
        } else {
            Num::of(fraction(self.m(), other.m()), e.wrapping_sub(32))
        }
    }

    /// The square root.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn root(&self) -> Num {
        if self.m() == 0 {
            return Num::ZERO;
        }
        // An even exponent: m stands for m · 2³², whose root has 32 bits and half of (e − 32) as
        // its exponent.
        let odd = self.e & 1 != 0;
        let (m, e) = if odd { (self.m() >> 1, self.e.wrapping_add(1)) } else { (self.m(), self.e) };
        let half = if odd { self.low as u8 & 1 } else { 0 };
        Num::new(root_of(m, half), (e >> 1).wrapping_sub(16))
    }

    /// The whole part, at most `u32::MAX`, and the rest in 2⁻³².
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn split(&self) -> (u32, u32) {
        if self.e > 0 {
            return (u32::MAX, 0);
        }
        let by = self.e.unsigned_abs();
        let both = if by < 64 { shifted(self.m(), by as u8) } else { 0 };
        ((both >> 32) as u32, both as u32)
    }

    /// The number whose mantissa is the upper half of the product of two mantissas.
    #[inline(always)]
    fn product(m: u32, a: i16, b: i16) -> Num {
        let e = a.wrapping_add(b).wrapping_add(32);
        if m >> 31 != 0 {
            Num::of(m, e)
        } else if m == 0 {
            Num::ZERO
        } else {
            Num::of(m << 1, e.wrapping_sub(1))
        }
    }
}

#[cfg(not(feature = "external-numbers"))]
impl From<u32> for Num {
    fn from(x: u32) -> Num {
        Num::new(x, 0)
    }
}

/// m >> by, for any by ≥ 0.
#[cfg(not(feature = "external-numbers"))]
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn shifted_down(mut m: u32, mut by: i16) -> u32 {
    if by >= 32 {
        return 0;
    }
    while by >= 8 {
        m >>= 8;
        by -= 8;
    }
    while by > 0 {
        m >>= 1;
        by -= 1;
    }
    m
}

/// a · b.
#[cfg(not(feature = "external-numbers"))]
fn short_product(a: u16, b: u16) -> u32 {
    u32::from(a).wrapping_mul(b.into())
}

/// m · 2³² >> by, `by` < 64.
#[cfg(not(feature = "external-numbers"))]
fn shifted(m: u32, by: u8) -> u64 {
    u64::from(m) << 32 >> by
}

/// floor(a · b / 2³²).
#[cfg(not(feature = "external-numbers"))]
fn high_product(a: u32, b: u32) -> u32 {
    (u64::from(a).wrapping_mul(b.into()) >> 32) as u32
}

/// floor(n · 2³² / d), for n < d and 2³¹ ≤ d.
#[cfg(not(feature = "external-numbers"))]
fn fraction(n: u32, d: u32) -> u32 {
    #[cfg(target_pointer_width = "64")]
    {
        ((u64::from(n) << 32) / u64::from(d.max(1))) as u32
    }
    #[cfg(not(target_pointer_width = "64"))]
    {
        fraction_bitwise(n, d)
    }
}

/// [`fraction`], with one subtraction per bit.
#[cfg(any(test, all(not(target_pointer_width = "64"), not(feature = "external-numbers"))))]
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn fraction_bitwise(mut n: u32, d: u32) -> u32 {
    let mut q = 0u32;
    for _ in 0..32u8 {
        let carry = n >> 31 != 0;
        n <<= 1;
        q <<= 1;
        if carry || n >= d {
            n = n.wrapping_sub(d);
            q |= 1;
        }
    }
    q
}

/// √((m + half/2) · 2³²) to a unit or two, for m ≥ 2³⁰.
///
/// The upper 16 bits of the root bit by bit, the rest by one division: with m = s² + r the root is
/// s + r/2s, too large by less than (r/2s)²/2s ≤ ½ · 2⁻¹⁶.
#[cfg(not(feature = "external-numbers"))]
fn root_of(m: u32, half: u8) -> u32 {
    let (mut rest, mut s, mut bit) = (m, 0u32, 1u32 << 30);
    while bit != 0 {
        let trial = s | bit;
        s >>= 1;
        if rest >= trial {
            rest = rest.wrapping_sub(trial);
            s |= bit;
        }
        bit >>= 2;
    }
    // 2¹⁵ ≤ s < 2¹⁶, rest ≤ 2s < 2¹⁷; the quotient of 17 bits is
    // (rest · 2¹⁶ + half · 2¹⁵) / 2s.
    let (mut rest, mut q) = (rest << 1 | u32::from(half), 0u32);
    let d = s << 2;
    for _ in 0..17u8 {
        q <<= 1;
        if rest >= d {
            rest = rest.wrapping_sub(d);
            q |= 1;
        }
        rest <<= 1;
    }
    (s << 16).saturating_add(q)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;

    fn wide(x: u64) -> Num {
        let mut number = Num::UNSET;
        number.set_wide(x);
        number
    }

    fn value(x: Num) -> f64 {
        f64::from(x.m()) * 2f64.powi(x.e.into())
    }

    fn num() -> impl Strategy<Value = Num> {
        prop_oneof![
            (any::<u32>(), -60i16..60).prop_map(|(m, e)| Num::new(m, e)),
            (0u32..100, -2i16..2).prop_map(|(m, e)| Num::new(m, e)),
        ]
    }

    fn close(got: Num, want: f64) -> bool {
        (value(got) - want).abs() <= want.abs() * 2f64.powi(-30)
    }

    #[test]
    fn an_inverse_is_a_quotient() {
        for x in [1, 2, 3, 1000, 65_536, 128_000, 2_000_000_000, u32::MAX] {
            let (number, inverse) = Num::and_inverse(x.into());
            assert_eq!((number, inverse), (Num::from(x), Num::ONE.over(&number)), "{x}");
        }
        for x in [32_000_000_000, 400_000_000_000, 200_000_000] {
            let (number, inverse) = Num::and_inverse(x);
            assert_eq!((number, inverse), (wide(x), Num::ONE.over(&number)), "{x}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn operations_match_f64(a in num(), b in num()) {
            let (x, y) = (value(a), value(b));
            prop_assert!(close(a.plus(&b), x + y));
            prop_assert!(close(a.times(&b), x * y));
            prop_assert!((value(a.roughly(&b)) - x * y).abs() <= x * y / 16384.0);
            prop_assert!(close(a.root(), x.sqrt()), "{a:?} {} {}", value(a.root()), x.sqrt());
            prop_assert_eq!(a.at_least(&b), x >= y);
            // A difference is as exact as its operands.
            let tolerance = x.max(y) * 2f64.powi(-30);
            prop_assert!((value(a.minus(&b)) - (x - y).max(0.0)).abs() <= tolerance);
            if !b.is_zero() {
                prop_assert!(close(a.over(&b), x / y));
            }
            if !a.is_zero() && !b.is_zero() && (x / y).log2().abs() < 127.0 {
                let n = i32::from(a.doublings_of(&b));
                prop_assert!(y * 2f64.powi(n) <= x && y * 2f64.powi(n + 1) > x);
            }
        }

        #[test]
        fn whole_and_part(a in num()) {
            let x = value(a);
            let (whole, part) = a.split();
            if x < 4294967296.0 {
                prop_assert_eq!(f64::from(whole), x.floor());
                prop_assert_eq!(f64::from(hand(&a).rounded_whole()), (x + 0.5).floor().min(4294967295.0));
                prop_assert_eq!(f64::from(part), (x.fract() * 4294967296.0).floor());
            } else {
                prop_assert_eq!(whole, u32::MAX);
            }
        }

        #[test]
        fn both_divisions_agree(n: u32, d in 1u32 << 31..) {
            let n = n % d;
            prop_assert_eq!(fraction(n, d), fraction_bitwise(n, d));
        }

        #[test]
        fn wide_integers(x: u64) {
            prop_assert!(close(wide(x), x as f64));
        }
    }

    /// The bounds themselves are not between the two.
    #[test]
    fn between_two_numbers() {
        let n = |n: u32| whole(n).number();
        let quarter = n(1).scaled(-2);
        for (to, want) in [(3, 7.0), (4, 7.0), (5, 5.0), (15, 15.0), (16, 7.0), (17, 7.0)] {
            let mut between = n(99);
            between.set_between(&n(4), &n(to), &n(16), &quarter);
            assert_eq!(value(between), want, "{to}");
        }
    }

    #[test]
    fn nothing_is_beyond_everything() {
        let huge = Num::ONE.over(&Num::ZERO);
        assert!(huge.at_least(&wide(u64::MAX)));
        assert_eq!(huge.split(), (u32::MAX, 0));
        assert_eq!(Num::ZERO.over(&Num::ZERO), Num::ZERO);
    }
}
