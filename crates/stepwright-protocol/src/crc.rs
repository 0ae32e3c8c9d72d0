//! The CRC-8 of a line: `sum.rs` says why this one.

/// The CRC-8 of one more byte, begun with 0: of a line of another kind, too.
///
/// ```
/// let sum = b"123456789".iter().fold(0, |sum, byte| stepwright_protocol::crc(sum, *byte));
/// assert_eq!(sum, 0xF4);
/// ```
pub const fn crc(sum: u8, byte: u8) -> u8 {
    let (mut sum, mut bit) = (sum ^ byte, 0);
    while bit < 8 {
        sum = if sum & 0x80 == 0 { sum << 1 } else { sum << 1 ^ 0x07 };
        bit += 1;
    }
    sum
}

/// The lower half of a byte as a hexadecimal digit.
pub const fn hex(half: u8) -> u8 {
    match half & 15 {
        half @ 0..10 => b'0' + half,
        half => b'A' + half - 10,
    }
}

/// A line without its checksum, `*` and two hexadecimal digits, and whether it had one: for the
/// programs with lines of their own. `None` if the checksum is that of another line.
///
/// ```
/// use stepwright_protocol::bare;
/// assert_eq!(bare(b"G100"), Some((&b"G100"[..], false)));
/// assert_eq!(bare(b"E*DC"), Some((&b"E"[..], true)));
/// assert_eq!(bare(b"E*DD"), None);
/// ```
pub fn bare(line: &[u8]) -> Option<(&[u8], bool)> {
    let mark = line.iter().fold(false, |marked, byte| marked | (*byte == b'*'));
    if !mark {
        return Some((line, false));
    }
    let [bare @ .., b'*', high, low] = line else { return None };
    let sum = bare.iter().fold(0, |sum, byte| crc(sum, *byte));
    let is = |half: u8, raw: u8| hex(half) == raw.to_ascii_uppercase();
    (is(sum >> 4, *high) && is(sum, *low)).then_some((bare, true))
}

#[cfg(test)]
mod tests {
    use super::bare;

    #[test]
    fn a_checksum_is_checked_where_there_is_one() {
        assert_eq!(bare(b"123456789*F4"), Some((&b"123456789"[..], true)));
        assert_eq!(bare(b"123456789"), Some((&b"123456789"[..], false)));
        for line in [&b"123456789*F5"[..], b"12345678*F4", b"*", b"1*F4*F4", b"1*4", b"*F4"] {
            assert_eq!(bare(line), None);
        }
    }
}
