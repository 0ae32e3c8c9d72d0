//! Ports as a motor's windings have them.

use stepwright::drive::Port;

use crate::chip;

/// A port of the chip, some of whose pins are a motor's.
pub trait Pins: Port {
    /// Makes these pins outputs, and leaves the others alone.
    fn drive(&mut self, mask: u8);
}

macro_rules! port {
    ($name:ident, $port:ident, $direction:ident, $read:ident, $toggle:ident) => {
        /// A port's pins. Writing ones to PINx toggles these and leaves the others alone.
        pub struct $name;

        impl $name {
            #[inline(always)]
            fn write_under(mask: u8, levels: u8) {
                // SAFETY: reading, and one write that leaves other pins alone.
                let port = unsafe { chip::$port::steal() };
                let changed = (port.$read().read().bits() ^ levels) & mask;
                // SAFETY: levels of pins touch no memory.
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
                // SAFETY: directions of pins touch no memory.
                port.$direction().modify(|r, w| unsafe { w.bits(r.bits() | mask) });
            }
        }
    };
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
