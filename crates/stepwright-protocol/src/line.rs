//! Splits bytes into lines.

use crate::BadLine;

/// The end of a line.
pub(crate) const CR: u8 = b'\r';
const LF: u8 = b'\n';

/// Collects up to `N` bytes (at most 65,535) and hands them out at the CR.
///
/// LF before and after a line is skipped. Within a line LF is a byte like any other, because a
/// single flipped bit turns the `*` before a checksum into an LF, and `G+4*33` would become
/// `G+433`. A line that is too long is not kept, only reported. Collection restarts after every CR,
/// so a stream that starts in the middle, is cut, or is plain noise costs at most one line.
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

    /// All zeros; [`begin`](Collector::begin) makes it a new collector.
    pub(crate) const fn blank() -> Collector<N> {
        Collector { bad: Some(BadLine::Empty), ..Collector::new() }
    }

    /// Starts empty.
    pub(crate) fn begin(&mut self) {
        self.bad = None;
    }

    /// Takes a byte. At a CR: the line without the CR, or the error.
    pub(crate) fn push(&mut self, byte: u8) -> Option<Result<&[u8], BadLine>> {
        if self.collect(byte) { Some(self.take()) } else { None }
    }

    /// Takes a byte. Returns true at a CR: the line is complete, and the caller must
    /// [take](Collector::take) it before the next byte.
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

    /// The complete line, or the error. Begins the next line.
    pub(crate) fn take(&mut self) -> Result<&[u8], BadLine> {
        let len = core::mem::take(&mut self.len);
        match self.bad.take() {
            None => self.bytes.get(..usize::from(len)).map(trimmed).ok_or(BadLine::Long),
            Some(bad) => Err(bad),
        }
    }

    /// The complete line, without taking it; `None` if it is bad.
    pub(crate) fn look(&self) -> Option<&[u8]> {
        if self.bad.is_some() {
            return None;
        }
        self.bytes.get(..usize::from(self.len)).map(trimmed)
    }

    /// Marks the line that is being collected as bad, whatever its bytes are.
    pub(crate) fn garble(&mut self) {
        self.bad = Some(BadLine::Garbled);
    }

    /// Discards the collected bytes.
    pub(crate) fn clear(&mut self) {
        self.len = 0;
        self.bad = None;
    }
}

/// A line without the LF bytes at its end.
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
