//! Mega: the shield's pins are spread over ports B, E, G and H; the emergency stop and the drivers'
//! fault are on port F.

use stepwright::drive::{Axes, Drive};
use stepwright::entry::Wiring;

use crate::chip::PORTF;
use crate::chip::{PORTB, PORTE, PORTG, PORTH};

/// On port E: STEP of axes 0 and 1, side by side, and DIR of axis 0.
const STEP_E: u8 = 4;
const DIRECTION_E: u8 = 1 << 3;
/// On port G: STEP of axis 2.
const STEP_G: u8 = 5;
/// On port H: DIR of axes 1 and 2, enable, and the switch of axis 0.
const DIRECTION_H: u8 = 3;
const ENABLE: u8 = 1 << 5;
const SWITCH_H: u8 = 6;
/// On port B: the switches of axes 1 and 2.
const SWITCH_B: u8 = 4;
/// On port F: A0, the shield's "Abort", and A1, its "Hold".
const EMERGENCY: u8 = 1 << 0;
const DRIVER_FAULT: u8 = 1 << 1;

/// STEP and DIR, for the step interrupt.
pub struct Pins {
    e: PORTE,
    g: PORTG,
}

/// The pins of the foreground: enable and switches.
pub struct Levels {
    b: PORTB,
}

/// Sets up all pins: steps low, drivers disabled, pull-ups at the switches and inputs.
pub fn pins(b: PORTB, e: PORTE, g: PORTG, h: PORTH) -> (Pins, Levels) {
    write!(e.ddre(), 0b11 << STEP_E | DIRECTION_E);
    write!(g.ddrg(), 1 << STEP_G);
    write!(h.porth(), ENABLE | 1 << SWITCH_H);
    write!(h.ddrh(), 0b11 << DIRECTION_H | ENABLE);
    write!(b.portb(), 0b11 << SWITCH_B);
    // SAFETY: nothing else has pins on this port.
    let f = unsafe { PORTF::steal() };
    write!(f.portf(), EMERGENCY | DRIVER_FAULT);
    (Pins { e, g }, Levels { b })
}

impl Pins {
    // Writing ones to PINx toggles these pins and leaves the others alone, in one cycle. Every
    // `begin` has its `end`.
    #[inline(always)]
    fn toggle(&mut self, axes: Axes) {
        write!(self.e.pine(), (axes & 0b011) << STEP_E);
        write!(self.g.ping(), (axes & 0b100) << (STEP_G - 2));
    }
}

impl Drive for Pins {
    #[inline(always)]
    fn begin(&mut self, axes: Axes) {
        self.toggle(axes);
    }

    #[inline(always)]
    fn end(&mut self, axes: Axes) {
        self.toggle(axes);
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        let high = super::level(axis, forward);
        if axis == 0 {
            set!(self.e.porte(), DIRECTION_E, high);
        } else {
            set_h((1 << DIRECTION_H) << ((axis - 1) & 1), high);
        }
    }
}

/// The meaning of the pins of entries: STEP's bit in its port. The step interrupt maps a turn,
/// whose bit is that of the first axis, to the port of DIR.
pub const fn wiring(axis: u8) -> Wiring {
    let step = if axis == 0 { 1 << STEP_E } else { 1 << STEP_G };
    Wiring::new(step, DIRECTION_E)
}

/// The level of DIR of an axis.
pub(super) fn direction(axis: u8) -> bool {
    // SAFETY: one read each.
    let (e, h) = unsafe { (PORTE::steal(), PORTH::steal()) };
    if axis == 0 {
        e.porte().read().bits() & DIRECTION_E != 0
    } else {
        h.porth().read().bits() & (1 << DIRECTION_H) << ((axis - 1) & 1) != 0
    }
}

/// Toggles DIR of these axes.
pub(super) fn turn_round(axes: Axes) {
    // SAFETY: one write each, which does not change the other pins.
    let (e, h) = unsafe { (PORTE::steal(), PORTH::steal()) };
    write!(e.pine(), (axes & 0b001) << 3);
    write!(h.pinh(), (axes & 0b110) << (DIRECTION_H - 1));
}

/// The switches' levels: bit 0 is the first axis, set when high (open).
pub(crate) fn switches() -> Axes {
    // SAFETY: reading pins has no effect.
    let (h, b) = unsafe { (PORTH::steal(), PORTB::steal()) };
    h.pinh().read().bits() >> SWITCH_H & 1 | b.pinb().read().bits() >> (SWITCH_B - 1) & 0b110
}

impl Levels {
    /// Sets the level of the enable pin.
    pub fn set_enable(&mut self, high: bool) {
        set_h(ENABLE, high);
    }

    /// The switches' levels: bit 0 is the first axis, set when high (open).
    pub fn switches(&self) -> Axes {
        switches()
    }

    /// The level of the emergency stop's pin.
    pub fn emergency(&self) -> bool {
        port_f() & EMERGENCY != 0
    }

    /// The level of the pin with the drivers' fault outputs.
    pub fn driver_fault(&self) -> bool {
        port_f() & DRIVER_FAULT != 0
    }
}

/// The levels on port F.
fn port_f() -> u8 {
    // SAFETY: reading pins has no effect.
    unsafe { PORTF::steal() }.pinf().read().bits()
}

/// Sets a pin of port H. Its address is too high for a single instruction, and both the interrupt
/// and the foreground have pins on it.
fn set_h(mask: u8, high: bool) {
    avr_device::interrupt::free(|_| {
        // SAFETY: no interrupt comes between reading and writing.
        let port = unsafe { PORTH::steal() };
        set!(port.porth(), mask, high);
    });
}
