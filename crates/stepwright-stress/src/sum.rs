//! The checksum of a line: CRC-8/SMBUS, as a long division of polynomials.

/// The remainder of the bytes and eight zero bits after them, divided by x⁸ + x² + x + 1.
pub fn crc(bytes: &[u8]) -> u8 {
    let bits = bytes.iter().chain([&0]).flat_map(|byte| (0..8).rev().map(move |n| byte >> n & 1));
    let rest = bits.fold(0u16, |rest, bit| {
        let rest = rest << 1 | u16::from(bit);
        if rest & 0x100 == 0 { rest } else { rest ^ 0x107 }
    });
    rest as u8
}

/// A line or an answer without its `*hh`, if the checksum is right.
pub fn bare(line: &[u8]) -> Option<&[u8]> {
    let (bare, tail) = line.split_at_checked(line.len().checked_sub(3)?)?;
    let want = format!("*{:02X}", crc(bare));
    tail.eq_ignore_ascii_case(want.as_bytes()).then_some(bare)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_value_and_the_example() {
        assert_eq!(crc(b"123456789"), 0xF4);
        assert_eq!(bare(b"G+4000*0B"), Some(&b"G+4000"[..]));
        assert_eq!((bare(b"G+4001*0B"), bare(b"0B")), (None, None));
    }
}
