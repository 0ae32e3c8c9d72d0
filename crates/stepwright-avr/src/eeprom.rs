//! Bytes that outlast a loss of power: 1 KiB on the Uno, 4 KiB on the Mega.

use core::arch::asm;

use avr_device::interrupt;
use stepwright_device::Memory;

use crate::chip::EEPROM;

/// The control register among the I/O registers, and two of its bits.
const EECR: u8 = 0x1F;
const EEMPE: u8 = 2;
const EEPE: u8 = 1;

/// The chip's EEPROM. Writing a byte takes 3.4 ms, and a byte endures 100,000 writes.
///
/// Addresses wrap at its size.
pub struct Eeprom(EEPROM);

impl Eeprom {
    /// Waits for the end of a write that was in progress when the chip was reset.
    pub fn new(registers: EEPROM) -> Eeprom {
        let eeprom = Eeprom(registers);
        while eeprom.is_writing() {}
        eeprom
    }
}

impl Memory for Eeprom {
    fn is_writing(&self) -> bool {
        self.0.eecr().read().eepe().bit_is_set()
    }

    fn read(&mut self, address: u16) -> u8 {
        self.0.eear().write(|w| w.set(address));
        self.0.eecr().write(|w| w.eere().set_bit());
        self.0.eedr().read().bits()
    }

    fn start_write(&mut self, address: u16, byte: u8) {
        self.0.eear().write(|w| w.set(address));
        self.0.eedr().write(|w| w.set(byte));
        interrupt::free(|_| {
            // SAFETY: the register is ours. EEPE must follow EEMPE within 4 cycles; these
            // instructions take 2, whatever the compiler does.
            unsafe {
                asm!(
                    "sbi {eecr}, {eempe}",
                    "sbi {eecr}, {eepe}",
                    eecr = const EECR,
                    eempe = const EEMPE,
                    eepe = const EEPE,
                    options(nostack, preserves_flags),
                );
            }
        });
    }
}
