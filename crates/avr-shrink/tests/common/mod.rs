//! A chip that implements only the manual of the instructions, and random programs for it.

pub mod chip;
pub mod programs;

/// Random numbers, the same for one seed.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        for _ in 0..8 {
            random.below(2);
        }
        random
    }

    pub fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 33) as usize % limit
    }

    pub fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// A byte, often one of the critical values.
    pub fn byte(&mut self) -> u8 {
        let any = self.below(256) as u8;
        self.of(&[0, 0, 1, 1, 2, 128, 255, any])
    }
}
