//! Uno and Nano: STEP and DIR of all axes are on port D, so that one write moves them in the same
//! cycle.

use stepwright::drive::{Axes, Drive};
use stepwright::entry::Wiring;

use crate::chip::PORTC;
use crate::chip::{PORTB, PORTD};

/// STEP of axis 0 is bit 2 of port D, DIR bit 5; the others follow.
const STEP: u8 = 2;
const DIRECTION: u8 = 5;
/// On port B: D8, and D9 to D11.
const ENABLE: u8 = 1 << 0;
const SWITCH: u8 = 1;
/// On port C: A0, the shield's "Abort", and A1, its "Hold".
const EMERGENCY: u8 = 1 << 0;
const DRIVER_FAULT: u8 = 1 << 1;

/// STEP and DIR, for the step interrupt.
pub struct Pins {
    port: PORTD,
}

/// The pins of the foreground: enable and switches.
pub struct Levels {
    port: PORTB,
}

/// Sets up all pins: steps low, drivers disabled, pull-ups at the switches and inputs.
pub fn pins(d: PORTD, b: PORTB) -> (Pins, Levels) {
    write!(d.ddrd(), 0b111 << STEP | 0b111 << DIRECTION);
    write!(b.portb(), ENABLE | 0b111 << SWITCH);
    write!(b.ddrb(), ENABLE);
    // SAFETY: nothing else has pins on this port.
    let c = unsafe { PORTC::steal() };
    write!(c.portc(), EMERGENCY | DRIVER_FAULT);
    (Pins { port: d }, Levels { port: b })
}

impl Drive for Pins {
    // Writing ones to PIND toggles these pins and leaves the others alone, in one cycle. Every
    // `begin` has its `end`.
    #[inline(always)]
    fn begin(&mut self, axes: Axes) {
        write!(self.port.pind(), axes << STEP);
    }

    #[inline(always)]
    fn end(&mut self, axes: Axes) {
        write!(self.port.pind(), axes << STEP);
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        let mask = (1 << DIRECTION) << (axis & 3);
        set!(self.port.portd(), mask, super::level(axis, forward));
    }
}

/// The meaning of the pins of entries: bits to write to PIND.
pub const fn wiring(axis: u8) -> Wiring {
    Wiring::new((1 << STEP) << (axis & 3), (1 << DIRECTION) << (axis & 3))
}

/// The level of DIR of an axis.
pub(super) fn direction(axis: u8) -> bool {
    // SAFETY: one read.
    let port = unsafe { PORTD::steal() };
    port.portd().read().bits() & wiring(axis).turn != 0
}

/// Toggles DIR of these axes.
pub(super) fn turn_round(axes: Axes) {
    // SAFETY: one write, which does not change the other pins.
    let port = unsafe { PORTD::steal() };
    write!(port.pind(), axes << DIRECTION);
}

/// The switches' levels: bit 0 is the first axis, set when high (open).
pub(crate) fn switches() -> Axes {
    // SAFETY: reading pins has no effect.
    unsafe { PORTB::steal() }.pinb().read().bits() >> SWITCH & 0b111
}

impl Levels {
    /// Sets the level of the enable pin.
    pub fn set_enable(&mut self, high: bool) {
        set!(self.port.portb(), ENABLE, high);
    }

    /// The switches' levels: bit 0 is the first axis, set when high (open).
    pub fn switches(&self) -> Axes {
        switches()
    }

    /// The level of the emergency stop's pin.
    pub fn emergency(&self) -> bool {
        port_c() & EMERGENCY != 0
    }

    /// The level of the pin with the drivers' fault outputs.
    pub fn driver_fault(&self) -> bool {
        port_c() & DRIVER_FAULT != 0
    }
}

/// The levels on port C.
fn port_c() -> u8 {
    // SAFETY: reading pins has no effect.
    unsafe { PORTC::steal() }.pinc().read().bits()
}
