//! The board's side of its device: pins, time, and bytes that outlast a loss of power.

use stepwright::Ticks;
use stepwright::drive::Axes;
use stepwright_device::{BoardIo, Mark, Memory, Reset, ResetIo};

use crate::board::{CLOCK, Levels, set_reverse};
use crate::clock::Clock;
use crate::eeprom::Eeprom;
use crate::{reset, watchdog};

/// Enable, switches, EEPROM and the time.
pub struct AvrIo {
    levels: Levels,
    eeprom: Eeprom,
    clock: Clock,
    millis: u32,
}

impl AvrIo {
    /// A panel whose time starts now.
    pub fn new(levels: Levels, eeprom: Eeprom, clock: Clock) -> AvrIo {
        AvrIo { levels, eeprom, clock, millis: 0 }
    }
}

impl Memory for AvrIo {
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

impl ResetIo for AvrIo {
    fn reset(&mut self) -> Reset {
        reset::reason()
    }

    fn mark(&self) -> Mark {
        reset::mark()
    }

    fn set_mark(&mut self, mark: Mark) {
        reset::set_mark(mark);
    }
}

impl BoardIo for AvrIo {
    #[inline(always)]
    fn tick(&mut self) {
        watchdog::feed();
        while self.clock.ticked() {
            self.millis = self.millis.wrapping_add(1);
        }
    }

    fn millis(&self) -> u32 {
        self.millis
    }

    fn ticks(&self, micros: u16) -> Ticks {
        Ticks::from(micros) * (CLOCK / 1_000_000)
    }

    fn switches(&self) -> Axes {
        self.levels.switches()
    }

    fn emergency(&self) -> bool {
        self.levels.emergency()
    }

    fn driver_fault(&self) -> bool {
        self.levels.driver_fault()
    }

    fn set_enable(&mut self, high: bool) {
        self.levels.set_enable(high);
    }

    fn set_reverse(&mut self, axes: Axes) {
        set_reverse(axes);
    }
}
