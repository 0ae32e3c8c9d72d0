//! Shares of a number, and logarithms: integers, the same bits on every machine.

use stepwright::fixed::{multiply, shl, zeros};

/// x · n / d, rounded down, and the remainder; saturates, and d = 0 counts as 1.
#[inline(always)]
pub(crate) fn mul_div(x: u64, n: u64, d: u64) -> (u64, u64) {
    let mut terms = [x, n, d];
    mul_div_in_place(&mut terms);
    (terms[0], terms[1])
}

/// x · n / d, rounded to nearest; saturates, and d = 0 counts as 1.
#[inline(always)]
pub(crate) fn share(x: u64, n: u64, d: u64) -> u64 {
    let mut terms = [x, n, d];
    share_in_place(&mut terms);
    terms[0]
}

/// [`share`] of x, n and d, with the result in the place of x. In place, because three numbers are
/// too many arguments for a Mega (`xtask/src/check.rs`).
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn share_in_place(terms: &mut [u64; 3]) {
    let d = terms[2].max(1);
    mul_div_in_place(terms);
    let rest = terms[1];
    let up = rest >= d.wrapping_sub(rest) && rest != 0;
    terms[0] = terms[0].saturating_add(u64::from(up));
}

/// [`mul_div`] of x, n and d, with the result in the places of x and n.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn mul_div_in_place(terms: &mut [u64; 3]) {
    let [x, n, d] = *terms;
    let d = d.max(1);
    let (q, rest) = if let Some(p) = x.checked_mul(n) {
        (p / d, p % d)
    } else {
        let (high, low) = multiply(x, n);
        if high >= d { (u64::MAX, 0) } else { long_divide(high, low, d) }
    };
    (terms[0], terms[1]) = (q, rest);
}

/// (high, low) / d and the remainder, for high < d.
#[inline(always)]
fn long_divide(high: u64, low: u64, d: u64) -> (u64, u64) {
    #[cfg(target_family = "wasm")]
    {
        long_divide_by_halves(high, low, d)
    }
    #[cfg(target_pointer_width = "64")]
    {
        let (n, d) = (u128::from(high) << 64 | u128::from(low), u128::from(d.max(1)));
        ((n / d) as u64, (n % d) as u64)
    }
    #[cfg(not(any(target_pointer_width = "64", target_family = "wasm")))]
    {
        let mut wide = (high, low);
        long_divide_bitwise(&mut wide, d);
        wide
    }
}

/// [`long_divide`] with two digits of 32 bits (Knuth's algorithm D): for WebAssembly, which only
/// divides 64 bits by 64.
#[cfg(any(test, target_family = "wasm"))]
fn long_divide_by_halves(high: u64, low: u64, d: u64) -> (u64, u64) {
    const HALF: u64 = 1 << 32;
    let by = d.leading_zeros();
    let d = d.wrapping_shl(by);
    let moved = u128::from(high) << 64 | u128::from(low);
    let moved = moved.wrapping_shl(by);
    let (top, bottom) = ((moved >> 64) as u64, moved as u64);
    let (first, second) = (d / HALF, d % HALF);
    // A digit from the upper halves, at most two too large, and the remainder.
    let digit = |rest: u64, next: u64| {
        let mut digit = rest / first.max(1);
        let mut left = rest % first.max(1);
        while digit >= HALF || digit * second > left * HALF + next {
            digit -= 1;
            left += first;
            if left >= HALF {
                break;
            }
        }
        let rest = rest.wrapping_mul(HALF).wrapping_add(next).wrapping_sub(digit.wrapping_mul(d));
        (digit, rest)
    };
    let (upper, rest) = digit(top, bottom / HALF);
    let (lower, rest) = digit(rest, bottom % HALF);
    (upper.wrapping_mul(HALF).wrapping_add(lower), rest.wrapping_shr(by))
}

/// [`long_divide`] without 128 bits: one subtraction per bit. In place, as above.
#[cfg(any(test, not(any(target_pointer_width = "64", target_family = "wasm"))))]
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn long_divide_bitwise(wide: &mut (u64, u64), d: u64) {
    let (mut rest, mut low, mut quotient) = (wide.0, wide.1, 0u64);
    for _ in 0..64 {
        let carry = rest >> 63 != 0;
        rest = rest << 1 | low >> 63;
        low <<= 1;
        quotient <<= 1;
        if carry || rest >= d {
            rest = rest.wrapping_sub(d);
            quotient |= 1;
        }
    }
    *wide = (quotient, rest);
}

/// log₂ n in 2⁻⁴⁸, to a few of the last places; 0 for 0.
///
/// The mantissa is squared 48 times: each time it exceeds 2 gives a bit.
pub(crate) fn log2(n: u64) -> u64 {
    let Some(whole) = n.checked_ilog2() else { return 0 };
    let mut mantissa = shl(n, zeros(n)); // 1 … 2 in 2⁻⁶³
    let mut log = u64::from(whole);
    for _ in 0..48 {
        let (square, _) = multiply(mantissa, mantissa); // 1 … 4 in 2⁻⁶²
        let bit = square >> 63;
        mantissa = if bit != 0 { square } else { square << 1 };
        log = log << 1 | bit;
    }
    log
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn all_long_divisions_agree(high: u64, low: u64, d in 1u64.., by in 0u8..64) {
            let d = (d >> by).max(1);
            let high = high % d;
            prop_assert_eq!(long_divide_by_halves(high, low, d), long_divide(high, low, d));
            let mut wide = (high, low);
            long_divide_bitwise(&mut wide, d);
            prop_assert_eq!(long_divide(high, low, d), wide);
        }

        #[test]
        fn shares_are_the_nearest(x: u64, n: u64, d in 1u64.., by in 0u8..64) {
            let (n, d) = (n >> by, d >> by | 1);
            let wide = u128::from(x) * u128::from(n);
            let (floor, nearest) = (wide / u128::from(d), (wide + u128::from(d / 2)) / u128::from(d));
            let most = u128::from(u64::MAX);
            prop_assert_eq!(u128::from(mul_div(x, n, d).0), floor.min(most));
            prop_assert_eq!(u128::from(share(x, n, d)), nearest.min(most));
        }

        #[test]
        fn logarithms_match_f64(n in 1u64.., by in 0u8..64) {
            let n = (n >> by).max(1);
            let (got, want) = (log2(n) as f64 / (1u64 << 48) as f64, (n as f64).log2());
            prop_assert!((got - want).abs() < 1e-13 * 64.0, "{got} {want}");
        }
    }
}
