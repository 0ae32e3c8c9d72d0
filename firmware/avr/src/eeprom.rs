//! Bytes that outlive the power: 1 KiB on the Uno, 4 KiB on the Mega.

use avr_device::interrupt;

use crate::chip::EEPROM;

/// The chip's EEPROM. A byte takes 3.4 ms to write, and lasts 100,000 writes.
pub struct Eeprom(EEPROM);

impl Eeprom {
    /// Takes the registers.
    pub fn new(registers: EEPROM) -> Eeprom {
        Eeprom(registers)
    }

    /// Whether a byte is still being written.
    pub fn busy(&self) -> bool {
        self.0.eecr().read().eepe().bit_is_set()
    }

    /// The byte at an address, which wraps at the EEPROM's size. Waits while
    /// another is being written.
    pub fn read(&self, address: u16) -> u8 {
        while self.busy() {}
        self.0.eear().write(|w| w.set(address & LAST));
        self.0.eecr().write(|w| w.eere().set_bit());
        self.0.eedr().read().bits()
    }

    /// Begins to write a byte. Waits while another is being written.
    pub fn start_write(&mut self, address: u16, byte: u8) {
        while self.busy() {}
        self.0.eear().write(|w| w.set(address & LAST));
        self.0.eedr().write(|w| w.set(byte));
        interrupt::free(|_| {
            // The second write must come within 4 cycles of the first.
            self.0.eecr().write(|w| w.eempe().set_bit());
            self.0.eecr().write(|w| w.eempe().set_bit().eepe().set_bit());
        });
    }
}

/// The last address.
#[cfg(feature = "uno")]
const LAST: u16 = 0x3FF;
#[cfg(feature = "mega")]
const LAST: u16 = 0xFFF;
