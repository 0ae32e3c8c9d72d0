//! The lamp on the board, at D13.

use crate::chip::{PORTB, Peripherals};

/// Its bit on port B.
const LAMP: u8 = if cfg!(feature = "uno") { 1 << 5 } else { 1 << 7 };

/// The port, of which this file writes one pin. With interrupts on too: none of them writes a
/// register of this port.
fn port() -> PORTB {
    // SAFETY: one pin, which nobody else writes.
    unsafe { Peripherals::steal() }.PORTB
}

/// Switches the lamp on or off.
pub fn set(on: bool) {
    drive();
    // SAFETY: any level is one.
    port()
        .portb()
        .modify(|r, w| unsafe { w.bits(if on { r.bits() | LAMP } else { r.bits() & !LAMP }) });
}

/// Switches the lamp on if it is off, and off if it is on.
pub fn toggle() {
    drive();
    // SAFETY: a one in PINB toggles a pin, and leaves the others alone.
    port().pinb().write(|w| unsafe { w.bits(LAMP) });
}

/// Makes the pin an output.
fn drive() {
    // SAFETY: the other pins stay as they are.
    port().ddrb().modify(|r, w| unsafe { w.bits(r.bits() | LAMP) });
}
