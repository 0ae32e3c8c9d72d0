//! The time for which the EEPROM is busy, and the effect of a loss of power on it.

/// A byte takes 3.4 ms to write (ATmega328P data sheet, table 8-2).
const WRITE: u64 = 54_400;

/// The byte that is being written.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Eeprom {
    busy: Option<(u64, u16)>,
    written: u64,
}

impl Eeprom {
    pub(crate) fn cycles(&self) -> u64 {
        WRITE
    }

    pub(crate) fn is_busy(&self) -> bool {
        self.busy.is_some()
    }

    pub(crate) fn begin(&mut self, now: u64, address: u16) {
        self.busy = Some((now, address));
    }

    pub(crate) fn end(&mut self) {
        self.busy = None;
        self.written += 1;
    }

    /// The number of completely written bytes.
    pub(crate) fn written(&self) -> u64 {
        self.written
    }

    /// Handles a loss of power: the address of the spoilt byte, if there is one.
    pub(crate) fn cut(&mut self) -> Option<u16> {
        self.busy.take().map(|(_, address)| address)
    }
}
