//! Bytes into lines.

use crate::BadLine;

/// The end of a line.
pub(crate) const CR: u8 = b'\r';
const LF: u8 = b'\n';

/// Collects up to `N` bytes (at most 65,535) and hands them out at the CR.
///
/// LF before and behind a line is skipped; within it LF is a byte as any other, for a
/// single flipped bit makes an LF of the `*` before a checksum, and `G+4*33` would be
/// `G+433`. A longer line is remembered as such, not kept, and everything starts again
/// after its CR, so a stream that starts in the middle, is cut, or is plain noise costs at
/// most one line.
#[derive(Clone, Debug)]
pub(crate) struct Collector<const N: usize> {
    bytes: [u8; N],
    len: u16,
    bad: Option<BadLine>,
}

impl<const N: usize> Collector<N> {
    pub(crate) const fn new() -> Collector<N> {
        const { assert!(N <= u16::MAX as usize) };
        Collector { bytes: [0; N], len: 0, bad: None }
    }

    /// All zeros, which [`begin`](Collector::begin) makes a new one.
    pub(crate) const fn blank() -> Collector<N> {
        Collector { bad: Some(BadLine::Empty), ..Collector::new() }
    }

    /// Nothing has come yet.
    pub(crate) fn begin(&mut self) {
        self.bad = None;
    }

    /// Takes a byte. At a CR: the line without it, or what is wrong with it.
    pub(crate) fn push(&mut self, byte: u8) -> Option<Result<&[u8], BadLine>> {
        if self.collect(byte) { Some(self.take()) } else { None }
    }

    /// Takes a byte. True at a CR: the line is complete, and is to be
    /// [taken](Collector::take) before the next byte comes.
    pub(crate) fn collect(&mut self, byte: u8) -> bool {
        match byte {
            CR => return true,
            LF if self.len == 0 => {}
            _ => match self.bytes.get_mut(usize::from(self.len)) {
                Some(place) => {
                    *place = byte;
                    self.len = self.len.wrapping_add(1);
                }
                None if byte == LF => {}
                None => self.bad = Some(BadLine::Long),
            },
        }
        false
    }

    /// The line that is complete, or what is wrong with it. The next one begins.
    pub(crate) fn take(&mut self) -> Result<&[u8], BadLine> {
        let len = core::mem::take(&mut self.len);
        match self.bad.take() {
            None => self.bytes.get(..usize::from(len)).map(trimmed).ok_or(BadLine::Long),
            Some(bad) => Err(bad),
        }
    }

    /// The line that is complete, which stays; `None` if something is wrong with it.
    pub(crate) fn look(&self) -> Option<&[u8]> {
        if self.bad.is_some() {
            return None;
        }
        self.bytes.get(..usize::from(self.len)).map(trimmed)
    }

    /// Marks the line that is being collected: it is bad, whatever it says.
    pub(crate) fn garble(&mut self) {
        self.bad = Some(BadLine::Garbled);
    }

    /// Throws away what has been collected.
    pub(crate) fn clear(&mut self) {
        self.len = 0;
        self.bad = None;
    }
}

/// A line without the LF bytes behind it.
fn trimmed(mut line: &[u8]) -> &[u8] {
    while let [before @ .., LF] = line {
        line = before;
    }
    line
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn lines(bytes: &[u8]) -> Vec<Result<Vec<u8>, BadLine>> {
        let mut line = Collector::<4>::new();
        bytes.iter().filter_map(|&b| Some(line.push(b)?.map(<[u8]>::to_vec))).collect()
    }

    #[test]
    fn a_cr_ends_a_line_and_lf_around_it_is_nothing() {
        assert_eq!(lines(b"PO\r\nF\n\rhalf"), [Ok(b"PO".to_vec()), Ok(b"F".to_vec())]);
        assert_eq!(lines(b"\n\n123\n\n\n\r"), [Ok(b"123".to_vec())]);
        assert_eq!(lines(b"1\n3\n\r\n\r"), [Ok(b"1\n3".to_vec()), Ok(Vec::new())]);
        assert_eq!(lines(b"\r\r"), [Ok(Vec::new()), Ok(Vec::new())]);
    }

    #[test]
    fn a_long_line_costs_only_itself() {
        assert_eq!(
            lines(b"1234\r12345\r123456789\rF\r"),
            [Ok(b"1234".to_vec()), Err(BadLine::Long), Err(BadLine::Long), Ok(b"F".to_vec())]
        );
    }

    #[test]
    fn a_lost_byte_spoils_its_line_only() {
        let mut line = Collector::<4>::new();
        line.push(b'F');
        line.garble();
        assert_eq!(line.push(CR), Some(Err(BadLine::Garbled)));
        line.push(b'F');
        assert_eq!(line.push(CR), Some(Ok(&b"F"[..])));
    }
}
