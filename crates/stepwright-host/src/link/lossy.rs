//! A line that loses or spoils bytes, for tests.

use std::io;
use std::time::Duration;

use super::Link;

/// The harm to a line. Bytes are counted from 0 in each direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Harm {
    /// A byte to the board does not arrive.
    LoseThere(usize),
    /// A byte from the board does not arrive.
    LoseBack(usize),
    /// A byte to the board arrives as another.
    SpoilThere(usize),
    /// A byte from the board arrives as another.
    SpoilBack(usize),
    /// A bit to the board is flipped; 8 bits to a byte.
    FlipThere(usize),
    /// A bit from the board is flipped.
    FlipBack(usize),
    /// All bytes to the board are lost from this one on.
    CutThere(usize),
    /// All bytes from the board are lost from this one on.
    CutBack(usize),
    /// Bytes in both directions are replaced, one in eighty, chosen by this seed.
    Noise(u64),
}

/// Whether the noise of `seed` spoils byte `n`.
fn strikes(seed: u64, n: usize) -> bool {
    let mut x = (seed << 32 | n as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (x ^ (x >> 29)).is_multiple_of(80)
}

/// A line with one harm.
pub struct Lossy<L> {
    line: L,
    harm: Harm,
    there: usize,
    back: usize,
}

impl<L> Lossy<L> {
    /// Adds `harm` to a line.
    pub fn new(line: L, harm: Harm) -> Lossy<L> {
        Lossy { line, harm, there: 0, back: 0 }
    }
}

/// A byte that is in no line of the protocol.
const SPOILED: u8 = b'~';

impl<L: Link> Link for Lossy<L> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        for &byte in bytes {
            let at = self.there;
            self.there += 1;
            match self.harm {
                Harm::LoseThere(n) if n == at => {}
                Harm::CutThere(n) if n <= at => {}
                Harm::SpoilThere(n) if n == at => self.line.write(&[SPOILED])?,
                Harm::FlipThere(n) if n / 8 == at => self.line.write(&[byte ^ 1 << (n % 8)])?,
                Harm::Noise(seed) if strikes(seed, 2 * at) => self.line.write(&[SPOILED])?,
                _ => self.line.write(&[byte])?,
            }
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        let count = self.line.read(buffer, limit)?;
        let mut kept = 0;
        for place in 0..count {
            let at = self.back;
            self.back += 1;
            let byte = match self.harm {
                Harm::LoseBack(n) if n == at => continue,
                Harm::CutBack(n) if n <= at => continue,
                Harm::SpoilBack(n) if n == at => SPOILED,
                Harm::FlipBack(n) if n / 8 == at => buffer[place] ^ 1 << (n % 8),
                Harm::Noise(seed) if strikes(seed, 2 * at + 1) => SPOILED,
                _ => buffer[place],
            };
            buffer[kept] = byte;
            kept += 1;
        }
        Ok(kept)
    }

    fn now(&self) -> Duration {
        self.line.now()
    }

    fn name(&self) -> String {
        self.line.name()
    }
}
