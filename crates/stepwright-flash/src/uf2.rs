//! UF2: a file of 512-byte blocks, which the boot loader of an RP2040 takes from its drive.
//!
//! Each block has the flash address of its 256 bytes, so blocks may come in any order. See
//! Microsoft's "USB Flashing Format (UF2)" and the RP2040's datasheet, "UF2 Format Details". (The
//! crate `uf2` had one release; `elf2uf2-rs` is a command, which reads ELF files.)

/// The bytes of flash in a block.
pub const PAYLOAD: usize = 256;

/// The size of a block in bytes.
pub const BLOCK: usize = 512;

/// The family id of an RP2040.
pub const RP2040: u32 = 0xE48B_FF56;

const BEGIN: [u32; 2] = [0x0A32_4655, 0x9E5D_5157];
const END: u32 = 0x0AB1_6F30;
/// Flag: the eighth number of the header is a family id.
const HAS_FAMILY: u32 = 0x2000;

/// A UF2 file with `bytes` for this address on, for a chip of this family. The last block is padded
/// with 0.
///
/// ```
/// use stepwright_flash::uf2::{RP2040, blocks};
/// assert_eq!(blocks(&[1; 300], 0x1000_0000, RP2040).len(), 2 * 512);
/// ```
pub fn blocks(bytes: &[u8], address: u32, family: u32) -> Vec<u8> {
    let count = bytes.len().div_ceil(PAYLOAD) as u32;
    let mut file = Vec::with_capacity(count as usize * BLOCK);
    for (n, payload) in (0u32..).zip(bytes.chunks(PAYLOAD)) {
        let begun = file.len();
        let to = address.wrapping_add(n * PAYLOAD as u32);
        let head = [BEGIN[0], BEGIN[1], HAS_FAMILY, to, PAYLOAD as u32, n, count, family];
        file.extend(head.iter().flat_map(|number| number.to_le_bytes()));
        file.extend(payload);
        file.resize(begun + BLOCK - 4, 0);
        file.extend(END.to_le_bytes());
    }
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The layout of the table "File format" of the specification, by its offsets.
    #[test]
    fn a_block_is_that_of_the_specification() {
        let bytes: Vec<u8> = (0..300).map(|n| (n % 251) as u8).collect();
        let file = blocks(&bytes, 0x1000_0000, 0xE48B_FF56);
        assert_eq!(file.len(), 1024);
        for (n, block) in file.chunks(512).enumerate() {
            let number =
                |at: usize| u32::from_le_bytes(block[at..at + 4].try_into().expect("four bytes"));
            assert_eq!(&block[..4], b"UF2\n");
            assert_eq!(number(4), 0x9E5D5157);
            assert_eq!(number(8), 0x0000_2000, "a family is given");
            assert_eq!(number(12), 0x1000_0000 + 256 * n as u32);
            assert_eq!([number(16), number(20), number(24)], [256, n as u32, 2]);
            assert_eq!(number(28), 0xE48B_FF56);
            assert_eq!(number(508), 0x0AB16F30);
        }
        assert_eq!(file[32..32 + 256], bytes[..256]);
        assert_eq!(file[512 + 32..512 + 32 + 44], bytes[256..]);
        assert!(file[512 + 32 + 44..1020].iter().all(|byte| *byte == 0));
    }
}
