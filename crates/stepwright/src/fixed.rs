//! Fixed-point arithmetic that a small chip can afford.
//!
//! Every function here is an exact integer function (floor of the true value), so a PC and an 8-bit
//! chip compute the same bits. Laws of other crates use them too. Three results are needed: the
//! square root of a speed², the time that a change of speed takes, and the interval at a speed.
//!
//! ```text
//! w   speed²                       10⁻⁶ (steps/s)²          u64, < 2⁶²
//! V   speed                        2⁻³³ · 0.001 steps/s     u64
//! t   time, interval               2⁻³² ticks               u64
//! ```
//!
//! | function | error | cost on ATmega328P |
//! | --- | --- | --- |
//! | [`root`] | below 2⁻⁶² of the value, or 2⁻³³ of 0.001 steps/s | 1 root, 1 division |
//! | [`Scale::time`] | below 2⁻⁶¹ of the value | 1 multiplication 64 × 64 |
//! | `slope` | below 2⁻²⁹ of the value | 1 division 64 / 32 |
//! | [`interval`] | at most 2⁻³³ ticks | 2 divisions 64 / 32 |

use crate::units::{Rate, Speed};

/// A time or a position in units of 2⁻³², with 32 integer bits.
pub type Q32 = u64;

/// One whole tick or step.
pub const ONE: Q32 = 1 << 32;

/// The largest speed² that [`root`] takes.
pub(crate) const W_MAX: u64 = (1 << 62) - 1;

/// x · 2^by, by < 64. An 8-bit chip shifts 64 bits in a loop: this is one function, not inlined at
/// every use.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub fn shl(x: u64, by: u8) -> u64 {
    x << (by & 63)
}

/// floor(x / 2^by), by < 64.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub fn shr(x: u64, by: u8) -> u64 {
    x >> (by & 63)
}

/// The number of leading zero bits; 64 for 0.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub fn zeros(x: u64) -> u8 {
    x.leading_zeros() as u8
}

/// √w: the speed of a speed², in 2⁻³³ · 0.001 steps/s.
///
/// The integer root gives the upper half, one Newton step the lower: with w = s² + r the root is
/// s + r/2s, and the omitted r²/8s³ is below half a unit of the last place.
pub fn root(w: u64) -> u64 {
    root_fine(w, 0)
}

/// [`root`] of w + `part`/2³²: for a corner, which is between steps.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub fn root_fine(w: u64, part: u32) -> u64 {
    let w = w.min(W_MAX);
    let shift = (zeros(w) & !1).min(62); // ≥ 2: the root stays below 2³¹
    let part = shr(u64::from(part) << 32, 64 - shift);
    let wide = shl(w, shift) | part;
    if wide == 0 {
        return 0;
    }
    let s = isqrt(wide).max(1); // 2³¹ ≤ s < 2³²
    let r = wide.wrapping_sub(s.wrapping_mul(s)); // ≤ 2s
    let v = (s << 31).wrapping_add((r << 30) / s);
    // v = √wide · 2³¹; the root of w is 2^(shift/2) smaller, and needs a factor of 2³³.
    if shift == 2 { v << 1 } else { shr(v, shift / 2 - 2) }
}

/// floor(√w).
fn isqrt(w: u64) -> u64 {
    #[cfg(any(target_pointer_width = "64", target_family = "wasm"))]
    {
        w.isqrt()
    }
    #[cfg(not(any(target_pointer_width = "64", target_family = "wasm")))]
    {
        isqrt_bitwise(w)
    }
}

/// [`isqrt`] without divisions: one bit per iteration. (The standard library's has a table, which
/// on an AVR is in RAM.)
#[cfg(any(test, not(any(target_pointer_width = "64", target_family = "wasm"))))]
fn isqrt_bitwise(w: u64) -> u64 {
    let (mut rest, mut root, mut bit) = (w, 0u64, 1u64 << 62);
    while bit != 0 {
        let trial = root | bit;
        root >>= 1;
        if rest >= trial {
            rest -= trial;
            root |= bit;
        }
        bit >>= 2;
    }
    root
}

/// The time of a change of speed, t = ΔV · f / a, as a multiplication.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scale {
    /// 2000·f / a2, scaled to have its top bit set.
    mantissa: u64,
    /// result = (ΔV · mantissa) >> shift.
    shift: u8,
}

impl Scale {
    /// For a timer of rate f and a slope of speed² of `a2` = 2a, in 10⁻⁶ (steps/s)² per step; `a2`
    /// = 0 counts as 1.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub fn new(rate: Rate, a2: u64) -> Scale {
        // t = Δv / a = (ΔV · 2⁻³³ / 1000) · (2·10⁶ / a2) seconds
        let top = 2000 * u64::from(rate.hz()); // < 2³⁹
        let a2 = a2.max(1);
        let (up, down) = (zeros(top), zeros(a2));
        let (n, d) = (shl(top, up), shl(a2, down));
        // n/d lies between ½ and 2; the quotient n·2⁶³/d has 63 or 64 bits.
        let mantissa = divide(n, d, 63);
        // mantissa = top/a2 · 2^(63 + up − down); the result needs ΔV · top/a2 · 2⁻³³ · 2³², a
        // shift by 63 + up − down + 1.
        Scale { mantissa, shift: 64 + up - down }
    }

    /// ΔV (see [`root`]) as a time in 2⁻³² ticks; saturates.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub fn time(self, dv: u64) -> Q32 {
        shift_wide(multiply(dv, self.mantissa), self.shift)
    }

    /// ΔV as a time in 2⁻¹⁶ ticks, of any length. 128 bits: for hosts.
    pub(crate) fn long_time(self, dv: u64) -> u128 {
        let wide = u128::from(dv) * u128::from(self.mantissa);
        wide.checked_shr(u32::from(self.shift) + 16).unwrap_or(0)
    }
}

/// (high, low) >> by, saturated to 64 bits; `by` ≤ 127.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn shift_wide((high, low): (u64, u64), by: u8) -> u64 {
    match by {
        0 => {
            if high == 0 {
                low
            } else {
                u64::MAX
            }
        }
        1..64 => {
            if shr(high, by) != 0 {
                u64::MAX
            } else {
                shl(high, 64 - by) | shr(low, by)
            }
        }
        64..128 => shr(high, by - 64),
        _ => 0,
    }
}

/// The full product of two 64-bit numbers as (high, low).
pub fn multiply(a: u64, b: u64) -> (u64, u64) {
    #[cfg(target_pointer_width = "64")]
    {
        let p = u128::from(a) * u128::from(b);
        ((p >> 64) as u64, p as u64)
    }
    #[cfg(not(target_pointer_width = "64"))]
    {
        multiply_halves(a, b)
    }
}

/// [`multiply`] without 128 bits: four products of 32-bit halves.
#[cfg(any(test, not(target_pointer_width = "64")))]
#[cfg_attr(not(any(target_pointer_width = "64", target_family = "wasm")), inline(never))]
fn multiply_halves(a: u64, b: u64) -> (u64, u64) {
    const LOW: u64 = 0xFFFF_FFFF;
    let (ah, al, bh, bl) = (a >> 32, a & LOW, b >> 32, b & LOW);
    let (low, high) = (al * bl, ah * bh);
    // Neither sum can overflow: (2³² − 1)² + 2 · (2³² − 1) < 2⁶⁴.
    let first = ah * bl + (low >> 32);
    let second = al * bh + (first & LOW);
    (high + (first >> 32) + (second >> 32), second << 32 | low & LOW)
}

/// floor(n · 2^bits / d), for n < 2d and `bits` ≤ 63.
pub fn divide(n: u64, d: u64, bits: u8) -> u64 {
    #[cfg(any(target_pointer_width = "64", target_family = "wasm"))]
    {
        ((u128::from(n) << bits) / u128::from(d.max(1))) as u64
    }
    #[cfg(not(any(target_pointer_width = "64", target_family = "wasm")))]
    {
        divide_bitwise(n, d, bits)
    }
}

/// [`divide`] without 128 bits: one subtraction per bit.
#[cfg(any(test, not(any(target_pointer_width = "64", target_family = "wasm"))))]
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn divide_bitwise(n: u64, d: u64, bits: u8) -> u64 {
    let (mut rest, mut quotient) = (n, 0u64);
    if rest >= d {
        rest -= d;
        quotient = 1;
    }
    for _ in 0..bits {
        let carry = rest >> 63 != 0;
        rest = rest.wrapping_shl(1);
        quotient <<= 1;
        if carry || rest >= d {
            rest = rest.wrapping_sub(d);
            quotient |= 1;
        }
    }
    quotient
}

/// f / v: the interval at a speed, to 29 bits, which is enough for a run's slope. Saturates at
/// `u64::MAX`, also for v = 0.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub(crate) fn slope(rate: Rate, v: u64) -> Q32 {
    if v == 0 {
        return u64::MAX;
    }
    let down = zeros(v);
    let v = (shl(v, down) >> 32).max(1); // 2³¹ ≤ v < 2³²
    let top = 1000 * u64::from(rate.hz()); // < 2³⁸
    let up = zeros(top);
    let q = shl(top, up) / v;
    // q = top/v · 2^up; the result is top/V · 2^(33 + 32), and V = v · 2^(32 − down)
    if 33 + down <= up {
        shr(q, up - down - 33)
    } else if zeros(q) > 33 + down - up {
        shl(q, 33 + down - up)
    } else {
        u64::MAX
    }
}

/// f / v for a speed, rounded to the nearest 2⁻³² tick; `u64::MAX` if it needs more than 32 integer
/// bits, also for v = 0.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub fn interval(rate: Rate, speed: Speed) -> Q32 {
    let v = u64::from(speed.millisteps());
    let top = 1000 * u64::from(rate.hz());
    if v == 0 || top / v > u64::from(u32::MAX) {
        return u64::MAX;
    }
    let (whole, rest) = (top / v, top % v);
    let part = ((rest << 32) + v / 2) / v; // rest < 2³⁰
    (whole << 32).saturating_add(part)
}

/// floor(x · part / 2³²): a part of x.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub(crate) fn portion(x: u64, part: u32) -> u64 {
    let part = u64::from(part);
    (x >> 32) * part + (((x & 0xFFFF_FFFF) * part) >> 32)
}

/// n / d as a position in 2⁻³² steps, rounded down; `u64::MAX` if it needs more than 32 integer
/// bits, also for d = 0.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub(crate) fn ratio(n: u64, d: u64) -> Q32 {
    if d == 0 || n / d > u64::from(u32::MAX) {
        return u64::MAX;
    }
    ((n / d) << 32) | divide(n % d, d, 32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rate(hz: u32) -> Rate {
        Rate::from_hz(hz).unwrap()
    }

    #[test]
    fn roots_of_squares_are_exact() {
        for v in [1u64, 2, 999, 1_000, 50_000, 1_000_000_000] {
            assert_eq!(root(v * v), v << 33);
        }
        assert_eq!(root(0), 0);
    }

    #[test]
    fn the_interval_of_a_speed() {
        // Austin: 120 rpm of a 1.8° motor on a 1 MHz timer.
        let v = Speed::from_steps(400).unwrap();
        assert_eq!(interval(Rate::MHZ, v), 2500 << 32);
        assert_eq!(slope(Rate::MHZ, root(v.squared())) >> 32, 2500);
        assert_eq!(interval(Rate::MAX, Speed::from_millisteps(1).unwrap()), u64::MAX);
        assert_eq!(slope(Rate::MAX, 0), u64::MAX);
    }

    #[test]
    fn the_time_of_a_change_of_speed() {
        // 400 steps/s at 400 steps/s² take a second.
        let scale = Scale::new(Rate::MHZ, 2 * 400 * 1_000_000);
        let v = root(400_000 * 400_000);
        assert_eq!((scale.time(v) + ONE / 2) >> 32, 1_000_000);
        assert_eq!((scale.long_time(v) + 0x8000) >> 16, 1_000_000);
    }

    proptest! {
        /// V² lies within a last place of w · 2⁶⁶.
        #[test]
        fn the_root_is_the_floor(w in 1u64..=W_MAX) {
            let v = u128::from(root(w));
            let lo = v.saturating_sub(2);
            let hi = v + 3;
            let square = |x: u128| -> (u128, u128) {
                let (a, b) = (x >> 32, x & 0xFFFF_FFFF);
                // x² >> 64 and the rest, without overflow for x < 2⁶⁴
                let top = a * a;
                let mid = 2 * a * b;
                let low = b * b;
                let sum = (mid << 32) + low;
                (top + (sum >> 64), sum & u128::from(u64::MAX))
            };
            let want = (u128::from(w) << 2, 0u128); // w · 2⁶⁶ >> 64
            prop_assert!(square(lo) <= want);
            prop_assert!(square(hi) >= want);
        }

        #[test]
        fn both_divisions_agree(n: u64, d in 1u64.., bits in 0u8..64) {
            let d = d.max(n / 2 + 1);
            prop_assert_eq!(divide(n, d, bits), divide_bitwise(n, d, bits));
        }

        #[test]
        fn both_roots_agree(w: u64, shift in 0u8..64) {
            prop_assert_eq!(isqrt(w >> shift), isqrt_bitwise(w >> shift));
        }

        #[test]
        fn both_products_agree(a: u64, b: u64) {
            prop_assert_eq!(multiply(a, b), multiply_halves(a, b));
        }

        #[test]
        fn times_match_f64(hz in 100_000u32..200_000_000, a2 in 1u64..200_000_000_000_000, w in 1u64..1_000_000_000_000_000_000) {
            let v = root(w);
            let want = (w as f64).sqrt() * 2000.0 * f64::from(hz) / a2 as f64;
            let got = Scale::new(rate(hz), a2);
            if want < 4e9 {
                let t = got.time(v) as f64 / ONE as f64;
                prop_assert!((t - want).abs() <= want * 1e-12 + 1e-6, "{t} {want}");
            }
            let t = got.long_time(v) as f64 / 65536.0;
            prop_assert!((t - want).abs() <= want * 1e-12 + 1e-4, "{t} {want}");
        }

        #[test]
        fn slopes_match_intervals(hz in 100_000u32..200_000_000, v in 100_000u32..1_000_000_000) {
            let exact = interval(rate(hz), Speed::from_millisteps(v).unwrap());
            let near = slope(rate(hz), root(u64::from(v) * u64::from(v)));
            prop_assert!(exact.abs_diff(near) <= (exact >> 29) + 2, "{exact} {near}");
        }

        #[test]
        fn ratios_and_portions(n: u64, d in 1u64..) {
            let q = ratio(n, d);
            if q != u64::MAX {
                prop_assert_eq!(u128::from(q), (u128::from(n) << 32) / u128::from(d));
            }
            let part = d as u32;
            prop_assert_eq!(u128::from(portion(n, part)), (u128::from(n) * u128::from(part)) >> 32);
        }
    }
}
