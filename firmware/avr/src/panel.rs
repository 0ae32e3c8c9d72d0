//! What the board lends its device: pins, time, and bytes that last.

use stepwright::drive::Axes;
use stepwright_device::{Memory, Panel};

use crate::board::{Levels, set_reverse};
use crate::clock::Clock;
use crate::eeprom::Eeprom;

/// Enable, switches, EEPROM and the time.
pub struct AvrPanel {
    levels: Levels,
    eeprom: Eeprom,
    clock: Clock,
    millis: u32,
}

impl AvrPanel {
    /// A panel whose time begins now.
    pub fn new(levels: Levels, eeprom: Eeprom, clock: Clock) -> AvrPanel {
        AvrPanel { levels, eeprom, clock, millis: 0 }
    }

    /// Looks at the clock. To be called at least every 16 ms.
    pub fn tick(&mut self) {
        self.millis = self.millis.wrapping_add(self.clock.passed().into());
    }
}

impl Memory for AvrPanel {
    fn read(&mut self, address: u16) -> u8 {
        self.eeprom.read(address)
    }

    fn start_write(&mut self, address: u16, byte: u8) {
        self.eeprom.start_write(address, byte);
    }

    fn is_writing(&self) -> bool {
        self.eeprom.is_writing()
    }
}

impl Panel for AvrPanel {
    fn millis(&self) -> u32 {
        self.millis
    }

    fn switches(&self) -> Axes {
        self.levels.switches()
    }

    fn set_enable(&mut self, high: bool) {
        self.levels.set_enable(high);
    }

    fn set_reverse(&mut self, axes: Axes) {
        set_reverse(axes);
    }
}
