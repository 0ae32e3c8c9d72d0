//! A line as it comes, byte by byte.

use super::LONGEST;

/// The line that comes, until it is [heard](crate::Remote::hear).
///
/// For the interrupt of a receiver: who takes bytes at once loses none, however long the main
/// program is kept from it.
///
/// ```
/// use stepwright_cycle::line::Incoming;
/// let mut line = Incoming::new();
/// assert!(!line.take(Some(b'V')));
/// assert!(line.take(Some(b'\r')));
/// ```
#[derive(Clone, Debug)]
pub struct Incoming {
    text: [u8; LONGEST],
    length: u8,
    /// A byte of it was damaged, or there were too many.
    bad: bool,
}

impl Incoming {
    /// Nothing has come.
    pub const fn new() -> Incoming {
        Incoming { text: [0; LONGEST], length: 0, bad: false }
    }

    /// Takes a byte of the line; `None` for one that was damaged. True at its end: it is to be
    /// heard before the next byte is taken.
    pub fn take(&mut self, byte: Option<u8>) -> bool {
        match byte {
            Some(b'\r') => return true,
            // Between two lines; within one it is a damaged byte.
            Some(b'\n') if self.length == 0 => {}
            Some(b'\n') => self.bad = true,
            Some(byte) => match self.text.get_mut(usize::from(self.length)) {
                Some(place) => {
                    *place = byte;
                    self.length = self.length.wrapping_add(1);
                }
                None => self.bad = true,
            },
            None => self.bad = true,
        }
        false
    }

    /// The line without its end, `None` if it is damaged; the next one begins.
    pub(crate) fn whole(&mut self) -> Option<&[u8]> {
        let length = usize::from(core::mem::take(&mut self.length));
        let bad = core::mem::take(&mut self.bad);
        if bad { None } else { self.text.get(..length) }
    }
}

impl Default for Incoming {
    fn default() -> Incoming {
        Incoming::new()
    }
}
