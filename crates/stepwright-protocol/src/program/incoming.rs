//! A line as it comes, byte by byte.

use crate::line::CR;

/// The line that comes, of up to `LONGEST` bytes (at most 255), until it is
/// [obeyed](crate::ProgramSlave::obey).
///
/// It may be a receiver's interrupt that [receives](Incoming::receive): who takes bytes at once
/// loses none, however long the main program is kept from it.
///
/// An LF is skipped between two lines; within a line it is a damaged byte, for a single flipped
/// bit makes an LF of the `*` before a checksum. A byte of 0x80 and more is a damaged one as well:
/// no text has it.
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
    /// A byte of it was damaged, or there were too many.
    damaged: bool,
}

impl<const LONGEST: usize> Incoming<LONGEST> {
    /// Nothing has come.
    pub const fn new() -> Incoming<LONGEST> {
        const { assert!(LONGEST <= u8::MAX as usize) };
        Incoming { text: [0; LONGEST], length: 0, damaged: false }
    }

    /// Receives a byte of the line; `None` for one that was lost or damaged. True at its end: it
    /// is to be obeyed before the next byte is received.
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

    /// The line is damaged: a byte of it was lost.
    pub fn garble(&mut self) {
        self.damaged = true;
    }

    /// The line without its end, and whether it is damaged; the next one begins.
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
