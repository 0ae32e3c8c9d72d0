//! Checksums.

/// CRC-32 as zlib has it, a bit at a time.
#[derive(Clone, Copy, Debug)]
pub struct Crc32(u32);

impl Default for Crc32 {
    fn default() -> Self {
        Crc32::new()
    }
}

impl Crc32 {
    /// Of nothing yet.
    pub const fn new() -> Crc32 {
        Crc32(u32::MAX)
    }

    /// A word, the lowest byte first.
    pub fn add(&mut self, word: u32) {
        self.bytes(&word.to_le_bytes());
    }

    /// Bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 ^= u32::from(*byte);
            for _ in 0..8 {
                let low = self.0 & 1;
                self.0 = self.0 >> 1 ^ 0xEDB8_8320 & low.wrapping_neg();
            }
        }
    }

    /// What it is.
    pub const fn end(self) -> u32 {
        !self.0
    }
}
