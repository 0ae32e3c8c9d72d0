//! Saturating sums and differences of 32 bits. On a small chip they are functions: inlined, each
//! takes 40 bytes on an 8-bit chip.

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
