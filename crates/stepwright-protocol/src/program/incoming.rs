//! A line as it arrives, byte by byte.

use crate::line::CR;

/// An incoming line of up to `LONGEST` bytes (at most 255), until it is
/// [obeyed](crate::ProgramSlave::obey).
///
/// A receiver's interrupt may call [`receive`](Incoming::receive): it takes each byte at once and
/// so loses none, however long the main program is delayed.
///
/// An LF between two lines is skipped. Within a line it is a damaged byte, because a single flipped
/// bit turns the `*` before a checksum into an LF. A byte of 0x80 or more is damaged as well: no
/// text has it.
///
/// ```
/// use stepwright_protocol::Incoming;
/// let mut line = Incoming::<80>::new();
/// assert!(!line.receive(Some(b'F')));
/// assert!(line.receive(Some(b'\r')));
/// ```
#[derive(Clone, Debug)]
pub struct Incoming<const LONGEST: usize> {
    text: [u8; LONGEST],
    length: u8,
    /// A byte of the line was damaged, or there were too many.
    damaged: bool,
}

impl<const LONGEST: usize> Incoming<LONGEST> {
    /// An empty line.
    pub const fn new() -> Incoming<LONGEST> {
        const { assert!(LONGEST <= u8::MAX as usize) };
        Incoming { text: [0; LONGEST], length: 0, damaged: false }
    }

    /// Receives a byte of the line; `None` for a byte that was lost or damaged. Returns true at the
    /// end of the line, which is to be obeyed before the next byte is received.
    pub fn receive(&mut self, byte: Option<u8>) -> bool {
        match byte {
            Some(CR) => return true,
            Some(b'\n') if self.length == 0 => {}
            Some(byte) if byte != b'\n' && byte < 0x80 => {
                match self.text.get_mut(usize::from(self.length)) {
                    Some(place) => {
                        *place = byte;
                        self.length = self.length.wrapping_add(1);
                    }
                    None => self.damaged = true,
                }
            }
            _ => self.damaged = true,
        }
        false
    }

    /// Marks the line as damaged: a byte of it was lost.
    pub fn garble(&mut self) {
        self.damaged = true;
    }

    /// The line without its end, and whether it is damaged. Begins the next line.
    pub fn take(&mut self) -> (&[u8], bool) {
        let length = usize::from(core::mem::take(&mut self.length));
        let damaged = core::mem::take(&mut self.damaged);
        (self.text.get(..length).unwrap_or_default(), damaged)
    }
}

impl<const LONGEST: usize> Default for Incoming<LONGEST> {
    fn default() -> Self {
        Incoming::new()
    }
}
