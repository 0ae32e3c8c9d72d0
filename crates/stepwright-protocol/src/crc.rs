//! The CRC-8 of a line. `sum.rs` explains the choice.

/// Updates a CRC-8 with one more byte. The initial value is 0.
///
/// ```
/// let sum = b"123456789".iter().fold(0, |sum, byte| stepwright_protocol::crc(sum, *byte));
/// assert_eq!(sum, 0xF4);
/// ```
pub const fn crc(sum: u8, byte: u8) -> u8 {
    let (mut sum, mut bit) = (sum ^ byte, 0u8);
    while bit < 8 {
        sum = if sum & 0x80 == 0 { sum << 1 } else { sum << 1 ^ 0x07 };
        bit += 1;
    }
    sum
}
