//! Windings over any `embedded-hal` pins.

use super::{Axes, Drive, Sequence};
use embedded_hal::digital::OutputPin;

/// One motor whose N lines are any pins, in the order of the sequence's lines: an L6219 has six.
///
/// Each line that changes takes a call. Where all lines are on one port, [`Coils`](super::Coils)
/// sets them in one write, so that no levels between two rows ever appear.
///
/// Errors of pins are ignored, because an interrupt cannot report them.
#[derive(Debug)]
pub struct CoilPins<P, const N: usize> {
    pins: [P; N],
    sequence: Sequence,
    levels: u8,
    phase: u8,
    forward: bool,
}

impl<P: OutputPin, const N: usize> CoilPins<P, N> {
    /// Takes the pins; no current flows.
    pub fn new(pins: [P; N], sequence: Sequence) -> CoilPins<P, N> {
        let off = sequence.off();
        // Starts with all levels inverted, so that each pin is set once.
        let mut coils = CoilPins { pins, sequence, levels: !off, phase: 0, forward: true };
        coils.write(off);
        coils
    }

    /// Switches the current on, at the motor's present phase.
    pub fn on(&mut self) {
        self.write(self.sequence.levels(self.phase));
    }

    /// Switches the current off.
    pub fn off(&mut self) {
        self.write(self.sequence.off());
    }

    /// Makes one step in the direction that is set.
    pub fn step(&mut self) {
        self.phase = self.sequence.after(self.phase, self.forward);
        self.on();
    }

    /// The row of the table at which the motor is.
    pub const fn phase(&self) -> u8 {
        self.phase
    }

    /// Sets the row at which the motor is, without a step: at power-up.
    pub fn restore(&mut self, phase: u8) {
        self.phase = phase & self.sequence.len().wrapping_sub(1);
    }

    /// Returns the pins.
    pub fn release(self) -> [P; N] {
        self.pins
    }

    fn write(&mut self, levels: u8) {
        let changed = core::mem::replace(&mut self.levels, levels) ^ levels;
        for (line, pin) in self.pins.iter_mut().enumerate().take(8) {
            if changed >> line & 1 != 0 {
                let _ = pin.set_state((levels >> line & 1 != 0).into());
            }
        }
    }
}

impl<P: OutputPin, const N: usize> Drive for CoilPins<P, N> {
    fn begin(&mut self, axes: Axes) {
        if axes & 1 != 0 {
            self.step();
        }
    }

    fn end(&mut self, _: Axes) {}

    fn direction(&mut self, axis: u8, forward: bool) {
        if axis == 0 {
            self.forward = forward;
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::sequence::L6219_FULL;
    use super::*;
    use embedded_hal_mock::eh1::digital::{Mock, State, Transaction};
    use std::vec::Vec;

    #[test]
    fn only_what_changes_is_written() {
        let (low, high) = (State::Low, State::High);
        // PHASE1, PHASE2, I01, I11, I02, I12: off, on, three steps, off.
        let expected: [&[State]; 6] = [
            &[low, high, low],
            &[low, high, low],
            &[high, low, high],
            &[high, low, high],
            &[high, low, high],
            &[high, low, high],
        ];
        let pins = expected.map(|levels| {
            Mock::new(&levels.iter().map(|&level| Transaction::set(level)).collect::<Vec<_>>())
        });
        let mut motor = CoilPins::new(pins, L6219_FULL);
        motor.on();
        for _ in 0..3 {
            motor.begin(1);
        }
        motor.off();
        for mut pin in motor.release() {
            pin.done();
        }
    }
}
