//! Checksums.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, NoTable};

/// A CRC-32 as in zlib.
#[derive(Clone)]
pub struct Crc32(Digest<'static, u32, NoTable>);

impl Default for Crc32 {
    fn default() -> Self {
        Crc32::new()
    }
}

impl Crc32 {
    /// The CRC of nothing yet.
    pub fn new() -> Crc32 {
        static CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
        Crc32(CRC.digest())
    }

    /// Adds a word, the lowest byte first.
    pub fn add(&mut self, word: u32) {
        self.bytes(&word.to_le_bytes());
    }

    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The final CRC.
    pub fn end(self) -> u32 {
        self.0.finalize()
    }
}
