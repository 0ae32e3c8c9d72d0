//! 32-bit random numbers from a seed, the same on every chip.

/// Marsaglia's xorshift (13, 17, 5).
#[derive(Clone, Copy, Debug)]
pub struct Luck(u32);

impl Luck {
    /// The generator of a number of a series. It starts at (n + 1)·2654435769 + s·2246822519 modulo
    /// 2³², or at 1 if that is 0, and drops the first eight values.
    pub fn of(series: u32, number: u32) -> Luck {
        let seed = number.wrapping_add(1).wrapping_mul(2_654_435_769);
        let seed = seed.wrapping_add(series.wrapping_mul(2_246_822_519));
        let mut luck = Luck(if seed == 0 { 1 } else { seed });
        for _ in 0..8 {
            luck.next();
        }
        luck
    }

    fn next(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }

    /// A number from 0 to `limit` − 1; 0 if `limit` is 0.
    pub fn below(&mut self, limit: u32) -> u32 {
        self.next().checked_rem(limit).unwrap_or(0)
    }

    /// A number from 2^`low` to 2^`high` − 1, equally often between any two neighbouring powers of
    /// two.
    pub fn about(&mut self, low: u32, high: u32) -> u32 {
        let size = 1u32.wrapping_shl(low.wrapping_add(self.below(high.wrapping_sub(low))));
        size.wrapping_add(self.below(size))
    }
}
