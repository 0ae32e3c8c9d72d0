//! Windings over any `embedded-hal` pins.

use super::{Axes, Drive, Sequence};
use embedded_hal::digital::OutputPin;

/// One motor whose N lines are any pins, in the order of the sequence's lines: an L6219
/// has six.
///
/// A call for each line that changes. Where all lie on one port, [`Coils`](super::Coils)
/// moves them in one write, and no row between two rows is ever seen.
///
/// A pin that reports an error is left alone: an interrupt has nobody to tell.
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
        // As if all were the other way round: each pin is set once.
        let mut coils = CoilPins { pins, sequence, levels: !off, phase: 0, forward: true };
        coils.write(off);
        coils
    }

    /// The current goes on, where the motor is.
    pub fn on(&mut self) {
        self.write(self.sequence.levels(self.phase));
    }

    /// The current goes off.
    pub fn off(&mut self) {
        self.write(self.sequence.off());
    }

    /// One step in the direction that was set.
    pub fn step(&mut self) {
        self.phase = self.sequence.after(self.phase, self.forward);
        self.on();
    }

    /// The row of the table that the motor is at.
    pub const fn phase(&self) -> u8 {
        self.phase
    }

    /// Says at which row it is, without a step: at power-up.
    pub fn restore(&mut self, phase: u8) {
        self.phase = phase & self.sequence.len().wrapping_sub(1);
    }

    /// Gives the pins back.
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
