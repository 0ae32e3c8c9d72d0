//! An ELF file of 32 bits: what lies in a chip's flash, and what it takes of flash and RAM.

use anyhow::{Context, Result, ensure};
use object::elf::{PT_LOAD, SHF_ALLOC, SHF_WRITE};
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{LittleEndian, Object, ObjectSection, SectionFlags};

/// A file that is little-endian.
type File<'d> = ElfFile32<'d, LittleEndian>;

/// What is to lie in the flash from this address on: the file's segments at their physical addresses, with 0xFF
/// between them.
pub fn flat(elf: &[u8], flash: u32) -> Result<Vec<u8>> {
    let mut flat = Vec::new();
    for head in File::parse(elf)?.elf_program_headers() {
        let segment =
            head.data(LittleEndian, elf).ok().context("a segment behind the file's end")?;
        if head.p_type(LittleEndian) != PT_LOAD || segment.is_empty() {
            continue;
        }
        let to =
            head.p_paddr(LittleEndian).checked_sub(flash).context("a segment before the flash")?;
        ensure!(to < 64 << 20, "a segment behind the flash");
        let (to, end) = (to as usize, to as usize + segment.len());
        if flat.len() < end {
            flat.resize(end, 0xFF);
        }
        flat[to..end].copy_from_slice(segment);
    }
    ensure!(!flat.is_empty(), "nothing to load");
    Ok(flat)
}

/// Bytes of flash, and of RAM without the stack: the sections that are loaded, and those that are written
/// to, of which the ones with contents take both.
pub fn sizes(elf: &[u8]) -> Result<[u64; 2]> {
    let (mut flash, mut ram) = (0, 0);
    for section in File::parse(elf)?.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        let flag = |flag: u32| sh_flags & u64::from(flag) != 0;
        // A linker's script may give the stack and the heap sections.
        let name = section.name_bytes()?;
        if !flag(SHF_ALLOC) || name.starts_with(b".stack") || name.starts_with(b".heap") {
            continue;
        }
        flash += section.file_range().map_or(0, |_| section.size());
        ram += if flag(SHF_WRITE) { section.size() } else { 0 };
    }
    Ok([flash, ram])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the ELF specification's tables: a head of 52 bytes.
    fn head(fields: &[(usize, u16)]) -> Vec<u8> {
        let mut elf = vec![0; 52];
        elf[..7].copy_from_slice(b"\x7FELF\x01\x01\x01");
        for (at, value) in fields {
            elf[*at..at + 2].copy_from_slice(&value.to_le_bytes());
        }
        elf
    }

    /// Two segments of 32 bytes each.
    #[test]
    fn segments_lie_at_their_physical_addresses() {
        let mut elf = head(&[(28, 52), (42, 32), (44, 2)]);
        elf.resize(52 + 2 * 32 + 8, 0);
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

    /// Four sections (none, code, variables, a stack), and their names.
    #[test]
    fn sections_are_flash_and_ram() {
        let names = b"\0.text\0.data\0.stack\0";
        let sections: [[u32; 10]; 5] = [
            [0; 10],
            [1, 1, 2 | 4, 0, 0, 100, 0, 0, 0, 0],
            [7, 1, 2 | 1, 0, 0, 20, 0, 0, 0, 0],
            [13, 8, 2 | 1, 0, 0, 4_000, 0, 0, 0, 0],
            [0, 3, 0, 0, 52 + 200, names.len() as u32, 0, 0, 0, 0],
        ];
        let mut elf = head(&[(0x20, 52), (0x2E, 40), (0x30, 5), (0x32, 4)]);
        elf.extend(sections.iter().flatten().flat_map(|word| word.to_le_bytes()));
        elf.extend(names);
        assert_eq!(sizes(&elf).expect("an ELF"), [120, 20]);
        assert!(sizes(b"no").is_err());
    }
}
