//! The lamp on the board, at D13.

use crate::chip::{PORTB, Peripherals};

/// Its bit on port B.
const LAMP: u8 = if cfg!(feature = "uno") { 1 << 5 } else { 1 << 7 };

/// The port. This file writes one pin of it, also with interrupts on: no interrupt writes a
/// register of this port.
fn port() -> PORTB {
    // SAFETY: one pin, which nothing else writes.
    unsafe { Peripherals::steal() }.PORTB
}

/// Switches the lamp on or off.
pub fn set(on: bool) {
    drive();
    // SAFETY: any level is valid.
    port()
        .portb()
        .modify(|r, w| unsafe { w.bits(if on { r.bits() | LAMP } else { r.bits() & !LAMP }) });
}

/// Switches the lamp on if it is off, and off if it is on.
pub fn toggle() {
    drive();
    // SAFETY: a one in PINB toggles a pin, and does not change the others.
    port().pinb().write(|w| unsafe { w.bits(LAMP) });
}

/// Makes the pin an output.
fn drive() {
    // SAFETY: the other pins are unchanged.
    port().ddrb().modify(|r, w| unsafe { w.bits(r.bits() | LAMP) });
}
