//! What surrounds the virtual board's motors: switches, the enable pin, an
//! EEPROM and a clock of milliseconds.

use std::cell::Cell;
use std::rc::Rc;

use stepwright::drive::Axes;
use stepwright::{Rate, Ticks};
use stepwright_device::{Memory, Panel, Store};

use crate::clock::Now;

/// The bytes of the board's EEPROM, which outlast a loss of power.
pub type Eeprom = [u8; Store::SIZE as usize];

/// An EEPROM that nobody has written to.
pub const EMPTY: Eeprom = [0xFF; Store::SIZE as usize];

/// Time that the writing of a byte takes, in µs, as on an AVR.
const WRITE: u32 = 3400;

/// The simulated panel.
pub(crate) struct SimPanel {
    now: Now,
    rate: Rate,
    /// Levels of the switches' pins. Nothing is connected: pulled up.
    pub(crate) switches: Axes,
    /// Level of the enable pin.
    pub(crate) enable: bool,
    /// Axes that turn the other way round; the drive looks here too.
    reverse: Rc<Cell<Axes>>,
    pub(crate) eeprom: Eeprom,
    /// When the byte that is being written is done.
    written: u64,
}

impl SimPanel {
    pub(crate) fn new(now: Now, rate: Rate, reverse: Rc<Cell<Axes>>, eeprom: Eeprom) -> SimPanel {
        SimPanel { now, rate, switches: Axes::MAX, enable: true, reverse, eeprom, written: 0 }
    }
}

impl Memory for SimPanel {
    fn read(&mut self, address: u16) -> u8 {
        self.eeprom.get(usize::from(address)).copied().unwrap_or(0xFF)
    }

    fn start_write(&mut self, address: u16, byte: u8) {
        if let Some(place) = self.eeprom.get_mut(usize::from(address)) {
            *place = byte;
        }
        self.written = self.now.get() + u64::from(self.rate.micros(WRITE));
    }

    fn is_writing(&self) -> bool {
        self.now.get() < self.written
    }
}

impl Panel for SimPanel {
    fn millis(&self) -> u32 {
        (self.now.get() * 1000 / u64::from(self.rate.hz())) as u32
    }

    fn ticks(&self, micros: u16) -> Ticks {
        self.rate.micros(micros.into())
    }

    fn switches(&self) -> Axes {
        self.switches
    }

    fn set_enable(&mut self, high: bool) {
        self.enable = high;
    }

    fn set_reverse(&mut self, axes: Axes) {
        self.reverse.set(axes);
    }
}
