//! The surroundings of the virtual board's motors: switches, the enable pin, an EEPROM and a clock of
//! milliseconds.

use core::cell::Cell;

use stepwright::drive::Axes;
use stepwright::{Rate, Ticks};
use stepwright_device::{BoardIo, Mark, Memory, Reset, ResetIo, Store};

use crate::clock::{LentNow, Present};
use crate::few::{EnableChanges, MOST_CHANGES};

/// The bytes of the board's EEPROM, which survive a loss of power.
pub type Eeprom = [u8; Store::SIZE as usize];

/// An EEPROM that was never written.
pub const EMPTY: Eeprom = [0xFF; Store::SIZE as usize];

/// The state of a board that survives a reset.
#[derive(Clone, Copy, Debug)]
pub struct Remains {
    /// Survives a loss of power too.
    pub eeprom: Eeprom,
    /// In RAM: only a short loss of power leaves it intact.
    pub mark: Mark,
}

/// The time to write a byte, in µs, as on an AVR.
const WRITE: u32 = 3400;

/// The simulated panel.
pub(crate) struct SimPanel<'q> {
    now: LentNow<'q>,
    rate: Rate,
    /// Levels of the switches' pins; unconnected pins are pulled up.
    pub(crate) switches: Axes,
    /// Levels of the emergency stop's pin and of the drivers' fault pin, pulled up too.
    pub(crate) emergency: bool,
    pub(crate) driver_fault: bool,
    /// The level of the enable pin.
    pub(crate) enable: bool,
    /// The changes of the enable pin since they were last read: times and levels.
    pub(crate) enable_changes: EnableChanges,
    /// The reversed axes; the drive reads them here too.
    reverse: &'q Cell<Axes>,
    reset: Reset,
    pub(crate) remains: Remains,
    /// When the byte in progress is written.
    written: u64,
}

impl<'q> SimPanel<'q> {
    pub(crate) fn new(
        now: LentNow<'q>,
        rate: Rate,
        reverse: &'q Cell<Axes>,
        reset: Reset,
        remains: Remains,
    ) -> SimPanel<'q> {
        let (switches, enable) = (Axes::MAX, true);
        let (emergency, driver_fault) = (true, true);
        SimPanel {
            now,
            rate,
            switches,
            emergency,
            driver_fault,
            enable,
            enable_changes: EnableChanges::default(),
            reverse,
            reset,
            remains,
            written: 0,
        }
    }
}

impl Memory for SimPanel<'_> {
    fn read(&mut self, address: u16) -> u8 {
        self.remains.eeprom.get(usize::from(address)).copied().unwrap_or(0xFF)
    }

    fn start_write(&mut self, address: u16, byte: u8) {
        if let Some(place) = self.remains.eeprom.get_mut(usize::from(address)) {
            *place = byte;
        }
        self.written = self.now.get() + u64::from(self.rate.micros(WRITE));
    }

    fn is_writing(&self) -> bool {
        self.now.get() < self.written
    }
}

impl ResetIo for SimPanel<'_> {
    fn reset(&mut self) -> Reset {
        self.reset
    }

    fn mark(&self) -> Mark {
        self.remains.mark
    }

    fn set_mark(&mut self, mark: Mark) {
        self.remains.mark = mark;
    }
}

impl BoardIo for SimPanel<'_> {
    fn millis(&self) -> u32 {
        // The rate is never 0, but its type does not say so.
        (self.now.get() * 1000 / u64::from(self.rate.hz().max(1))) as u32
    }

    fn ticks(&self, micros: u16) -> Ticks {
        self.rate.micros(micros.into())
    }

    fn switches(&self) -> Axes {
        self.switches
    }

    fn emergency(&self) -> bool {
        self.emergency
    }

    fn driver_fault(&self) -> bool {
        self.driver_fault
    }

    fn set_enable(&mut self, high: bool) {
        // Further changes are dropped: a user that never reads them needs none.
        if self.enable != high && self.enable_changes.len() < MOST_CHANGES {
            self.enable_changes.push((self.now.get(), high));
        }
        self.enable = high;
    }

    fn set_reverse(&mut self, axes: Axes) {
        if self.reverse.replace(axes) != axes {
            // All axes rest, so nothing happens meanwhile.
            self.now.set(self.now.get() + u64::from(self.rate.micros(1000)));
        }
    }
}
