//! Ports for a motor's windings.

use stepwright::drive::Port;

use crate::chip;

/// A port of the chip with pins of a motor.
pub trait Pins: Port {
    /// Makes these pins outputs, without changing the others.
    fn drive(&mut self, mask: u8);
}

macro_rules! port {
    ($name:ident, $port:ident, $direction:ident, $read:ident, $toggle:ident) => {
        /// A port's pins. Writing ones to PINx toggles these pins and does not change the others.
        pub struct $name;

        impl $name {
            #[inline(always)]
            fn write_under(mask: u8, levels: u8) {
                // SAFETY: a read, and one write that does not change other pins.
                let port = unsafe { chip::$port::steal() };
                let changed = (port.$read().read().bits() ^ levels) & mask;
                // SAFETY: levels of pins affect no memory.
                port.$toggle().write(|w| unsafe { w.bits(changed) });
            }
        }

        impl Port for $name {
            fn set(&mut self, mask: u8) {
                $name::write_under(mask, mask);
            }
            fn clear(&mut self, mask: u8) {
                $name::write_under(mask, 0);
            }
            #[inline(always)]
            fn write(&mut self, mask: u8, levels: u8) {
                $name::write_under(mask, levels);
            }
        }

        impl Pins for $name {
            fn drive(&mut self, mask: u8) {
                // SAFETY: only the main program sets directions of pins.
                let port = unsafe { chip::$port::steal() };
                // SAFETY: directions of pins affect no memory.
                port.$direction().modify(|r, w| unsafe { w.bits(r.bits() | mask) });
            }
        }
    };
}

/// A port that is chosen while the program runs.
///
/// PINx, DDRx and PORTx are adjacent, at the same addresses in all models of a chip.
pub struct AnyPort(u16);

impl AnyPort {
    /// A placeholder for use with the mask 0, which affects no pin.
    pub const NONE: AnyPort = AnyPort(0x23);

    /// The port with this letter, if the chip has it and these pins, and none of them is the serial
    /// line's.
    pub fn of(letter: u8, mask: u8) -> Option<AnyPort> {
        let (place, pins) = if cfg!(feature = "mega") {
            match letter {
                b'A' => (0x20, 0xFF),
                b'B' => (0x23, 0xFF),
                b'C' => (0x26, 0xFF),
                b'D' => (0x29, 0b1000_1111),
                b'E' => (0x2C, 0b0011_1000),
                b'F' => (0x2F, 0xFF),
                b'G' => (0x32, 0b0010_0111),
                b'H' => (0x100, 0b0111_1011),
                b'J' => (0x103, 0b0000_0011),
                b'K' => (0x106, 0xFF),
                b'L' => (0x109, 0xFF),
                _ => return None,
            }
        } else {
            match letter {
                b'B' => (0x23, 0b0011_1111),
                b'C' => (0x26, 0b0011_1111),
                b'D' => (0x29, 0b1111_1100),
                _ => return None,
            }
        };
        (mask & !pins == 0).then_some(AnyPort(place))
    }

    /// The address of PINx; DDRx and PORTx follow it.
    pub const fn place(&self) -> u16 {
        self.0
    }

    /// The address of PINx, DDRx or PORTx: 0, 1, 2.
    #[inline(always)]
    fn register(&self, which: u16) -> *mut u8 {
        usize::from(self.0.wrapping_add(which)) as *mut u8
    }
}

impl Port for AnyPort {
    fn set(&mut self, mask: u8) {
        self.write(mask, mask);
    }
    fn clear(&mut self, mask: u8) {
        self.write(mask, 0);
    }
    #[inline(always)]
    fn write(&mut self, mask: u8, levels: u8) {
        // SAFETY: a port's registers: `of` returns no other address. The write does not change
        // other pins.
        unsafe {
            let changed = (self.register(2).read_volatile() ^ levels) & mask;
            self.register(0).write_volatile(changed);
        }
    }
}

impl Pins for AnyPort {
    fn drive(&mut self, mask: u8) {
        // SAFETY: as above; only the main program sets directions of pins.
        unsafe {
            let register = self.register(1);
            register.write_volatile(register.read_volatile() | mask);
        }
    }
}

#[cfg(feature = "mega")]
port!(PortA, PORTA, ddra, porta, pina);
port!(PortB, PORTB, ddrb, portb, pinb);
#[cfg(feature = "uno")]
port!(PortD, PORTD, ddrd, portd, pind);
#[cfg(feature = "mega")]
port!(PortE, PORTE, ddre, porte, pine);
#[cfg(feature = "mega")]
port!(PortH, PORTH, ddrh, porth, pinh);
