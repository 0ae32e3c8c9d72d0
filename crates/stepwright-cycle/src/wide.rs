//! 64-bit products and quotients with 32-bit arithmetic, for small chips.

/// a / b, if it is below 2³²: bit by bit in 32 bits, in a tenth of the code and a third of the time
/// of a small chip's general 64-bit division.
pub(crate) fn quotient(a: u64, b: u32) -> u32 {
    let (mut rest, mut low) = ((a >> 32) as u32, a as u32);
    for _ in 0..32 {
        let over = rest >> 31 != 0;
        rest = rest << 1 | low >> 31;
        low <<= 1;
        if over || rest >= b {
            rest = rest.wrapping_sub(b);
            low |= 1;
        }
    }
    low
}

/// a modulo b, which is not 0, in the same way.
pub(crate) fn remainder(a: u64, b: u32) -> u32 {
    // The same digits, the first of which are taken modulo b beforehand.
    let above = u64::from((a >> 32) as u32 % b) << 32;
    let a = above | u64::from(a as u32);
    (a as u32).wrapping_sub(quotient(a, b).wrapping_mul(b))
}

/// a · b from 16-bit products: a 64-bit product takes a small chip 660 cycles.
#[inline(never)] // 200 bytes there
pub(crate) const fn product(a: u32, b: u32) -> u64 {
    let (a1, a0, b1, b0) = (a >> 16, a & 0xFFFF, b >> 16, b & 0xFFFF);
    let (cross, above) = a1.wrapping_mul(b0).overflowing_add(a0.wrapping_mul(b1));
    let (low, carry) = a0.wrapping_mul(b0).overflowing_add(cross << 16);
    let high = a1.wrapping_mul(b1).wrapping_add(cross >> 16);
    let high = high.wrapping_add((above as u32) << 16).wrapping_add(carry as u32);
    (high as u64) << 32 | low as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_product_of_halves_is_the_product(
            a in prop_oneof![any::<u32>(), Just(u32::MAX), 0u32..70_000],
            b in prop_oneof![any::<u32>(), Just(u32::MAX), 0u32..70_000],
        ) {
            prop_assert_eq!(product(a, b), u64::from(a) * u64::from(b));
        }

        #[test]
        fn a_quotient_is_the_quotient(
            most in prop_oneof![any::<u32>(), Just(u32::MAX), 0u32..70_000],
            b in prop_oneof![1..=u32::MAX, Just(u32::MAX), 1u32..70_000],
            rest in prop_oneof![Just(0), any::<u32>()],
        ) {
            let a = u64::from(most) * u64::from(b) + u64::from(rest % b);
            prop_assert_eq!(quotient(a, b), most);
            prop_assert_eq!(remainder(a, b), rest % b);
        }

        #[test]
        fn a_remainder_is_the_remainder(a in any::<u64>(), b in 1..=u32::MAX) {
            prop_assert_eq!(u64::from(remainder(a, b)), a % u64::from(b));
        }
    }
}
