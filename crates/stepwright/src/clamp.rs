//! Sums and differences that stay within 32 bits, out of line on a small chip: in place,
//! an 8-bit one takes 40 bytes for each.

/// a + b, at most `u32::MAX`.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub(crate) fn sum(a: u32, b: u32) -> u32 {
    a.saturating_add(b)
}

/// a − b, at least 0.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub(crate) fn less(a: u32, b: u32) -> u32 {
    a.saturating_sub(b)
}
