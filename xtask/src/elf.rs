//! An ELF file of 32 bits, as it lies in a chip's flash.

use anyhow::{Context, Result, ensure};

/// A segment that is loaded.
const LOAD: u32 = 1;

/// What is to lie in the flash from this address on: the file's segments at their physical addresses, with 0xFF
/// between them.
pub fn flat(elf: &[u8], flash: u32) -> Result<Vec<u8>> {
    ensure!(elf.starts_with(b"\x7FELF\x01\x01"), "no ELF file of 32 bits, little-endian");
    let (table, size) = (word(elf, 28)? as usize, half(elf, 42)?);
    let mut flat = Vec::new();
    for n in 0..half(elf, 44)? {
        let head = table + n * size;
        let field = |k: usize| word(elf, head + 4 * k);
        let (from, to, bytes) = (field(1)? as usize, field(3)?, field(4)? as usize);
        if field(0)? != LOAD || bytes == 0 {
            continue;
        }
        let to = to.checked_sub(flash).context("a segment before the flash")? as usize;
        ensure!(to < 64 << 20, "a segment behind the flash");
        let segment = elf.get(from..from + bytes).context("a segment behind the file's end")?;
        if flat.len() < to + bytes {
            flat.resize(to + bytes, 0xFF);
        }
        flat[to..to + bytes].copy_from_slice(segment);
    }
    ensure!(!flat.is_empty(), "nothing to load");
    Ok(flat)
}

fn word(elf: &[u8], at: usize) -> Result<u32> {
    let bytes = elf.get(at..at + 4).context("the file ends early")?;
    Ok(u32::from_le_bytes(bytes.try_into()?))
}

fn half(elf: &[u8], at: usize) -> Result<usize> {
    let bytes = elf.get(at..at + 2).context("the file ends early")?;
    Ok(u16::from_le_bytes(bytes.try_into()?).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the ELF specification's tables: a head of 52 bytes, and two segments of 32.
    #[test]
    fn segments_lie_at_their_physical_addresses() {
        let mut elf = vec![0; 52 + 2 * 32 + 8];
        elf[..6].copy_from_slice(b"\x7FELF\x01\x01");
        (elf[28], elf[42], elf[44]) = (52, 32, 2);
        let mut segment = |n: usize, numbers: [u32; 5]| {
            for (k, number) in numbers.into_iter().enumerate() {
                let at = 52 + 32 * n + 4 * k;
                elf[at..at + 4].copy_from_slice(&number.to_le_bytes());
            }
        };
        segment(0, [1, 116, 0x100, 0x100, 3]);
        segment(1, [1, 119, 0x2000_0000, 0x106, 2]);
        elf[116..121].copy_from_slice(&[1, 2, 3, 4, 5]);
        assert_eq!(flat(&elf, 0x100).expect("an image"), [1, 2, 3, 255, 255, 255, 4, 5]);
        assert!(flat(&elf, 0x101).is_err() && flat(&elf[..100], 0x100).is_err());
    }
}
