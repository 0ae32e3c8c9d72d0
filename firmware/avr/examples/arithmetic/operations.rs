// Operations of wide numbers, which a compiler for 8 bits has to translate correctly. One text for
// the chip (`main.rs`) and for the host that knows the results
// (`firmware/rig/tests/arithmetic.rs`): each operation makes two numbers of two. The macro passes
// all of them to another macro.

macro_rules! operations {
    ($each:ident) => {
        $each! {
            multiply(a, b): (a.wrapping_mul(b), (a as i64).wrapping_mul(b as i64) as u64);
            multiply_halves(a, b): (
                u64::from(a as u32) * u64::from(b as u32),
                (i64::from(a as i32) * i64::from(b as i32)) as u64,
            );
            multiply_by_half(a, b): (
                (a as i64).wrapping_mul(i64::from(b as u32)) as u64,
                (a as i64).wrapping_mul(i64::from(b as i32)) as u64,
            );
            multiply_by_constants(a, b): (
                a.wrapping_mul(1_000_000),
                (b as i64).wrapping_mul(-3_999_999_999) as u64,
            );
            multiply_overflowing(a, b): {
                let (product, over) = a.overflowing_mul(b);
                (product, u64::from(over))
            };
            multiply_overflowing_signed(a, b): {
                let (product, over) = (a as i64).overflowing_mul(b as i64);
                (product as u64, u64::from(over))
            };
            multiply_saturating(a, b): (a.saturating_mul(b), a.saturating_mul(b & 0xFFFF_FFFF));
            multiply_saturating_signed(a, b): (
                (a as i64).saturating_mul(b as i64) as u64,
                (a as i64).saturating_mul(i64::from(b as u32)) as u64,
            );
            multiply_32_overflowing(a, b): {
                let (product, over) = (a as u32).overflowing_mul(b as u32);
                let (signed, beyond) = (a as i32).overflowing_mul(b as i32);
                (u64::from(product) << 1 | u64::from(over), (signed as u64) << 1 | u64::from(beyond))
            };
            multiply_to_128(a, b): {
                let product = u128::from(a) * u128::from(b);
                (product as u64, (product >> 64) as u64)
            };
            multiply_to_128_signed(a, b): {
                let product = i128::from(a as i64) * i128::from(b as i64);
                (product as u64, (product >> 64) as u64)
            };
            divide(a, b): (a.checked_div(b).unwrap_or(7), a.checked_rem(b).unwrap_or(7));
            divide_signed(a, b): (
                (a as i64).checked_div(b as i64).unwrap_or(7) as u64,
                (a as i64).checked_rem(b as i64).unwrap_or(7) as u64,
            );
            divide_by_constants(a, b): (a / 1000, ((b as i64) % 1_000_000) as u64);
            divide_32(a, b): (
                u64::from((a as u32).checked_div(b as u32).unwrap_or(7)),
                (a as i32).checked_rem(b as i32).unwrap_or(7) as u64,
            );
            shift_left(a, b): (a.wrapping_shl(b as u32), (a as u32).wrapping_shl(b as u32).into());
            shift_right(a, b): (a.wrapping_shr(b as u32), (a as u32).wrapping_shr(b as u32).into());
            shift_right_signed(a, b): (
                (a as i64).wrapping_shr(b as u32) as u64,
                (a as i32).wrapping_shr(b as u32) as u64,
            );
            shift_128(a, b): {
                let wide = u128::from(a) << 64 | u128::from(b);
                let wide = wide.wrapping_shr(b as u32) ^ wide.wrapping_shl(a as u32);
                (wide as u64, (wide >> 64) as u64)
            };
            rotate(a, b): (a.rotate_left(b as u32), a.rotate_right(b as u32));
            add_saturating(a, b): (a.saturating_add(b), (a as i64).saturating_add(b as i64) as u64);
            subtract_saturating(a, b): (
                a.saturating_sub(b),
                (a as i64).saturating_sub(b as i64) as u64,
            );
            add_128(a, b): {
                let sum = (u128::from(a) << 64 | u128::from(b))
                    .wrapping_add(u128::from(b) << 32 | u128::from(a));
                (sum as u64, (sum >> 64) as u64)
            };
            compare(a, b): (
                u64::from(a < b) | u64::from((a as i64) < b as i64) << 1 | u64::from(a == b) << 2,
                a.abs_diff(b),
            );
            differ_signed(a, b): ((a as i64).abs_diff(b as i64), (a as i64).wrapping_neg() as u64);
            count_bits(a, b): (
                u64::from(a.leading_zeros()) << 32 | u64::from(b.trailing_zeros()),
                u64::from(a.count_ones()),
            );
        }
    };
}
