//! Step and direction over any `embedded-hal` pins.

use super::{Axes, Drive};
use embedded_hal::digital::OutputPin;

/// The pins of one axis.
#[derive(Debug)]
pub struct Pins<S, D> {
    /// STEP, which rises for a step.
    pub step: S,
    /// DIR, high for forward.
    pub direction: D,
    /// Whether a low DIR means forward.
    pub invert_direction: bool,
}

/// N step/direction drivers (A4988, DRV8825, TMC2209 …) on pins of the same two types; with
/// `embedded-hal`'s erased pins these may be any pins.
///
/// Each pin takes a call, 2–5 cycles on most chips. Where all STEP pins are on one port,
/// [`PortDrive`](super::PortDrive) sets them in one write.
///
/// Errors of pins are ignored, because an interrupt cannot report them.
#[derive(Debug)]
pub struct StepDir<S, D, const N: usize> {
    pins: [Pins<S, D>; N],
}

impl<S: OutputPin, D: OutputPin, const N: usize> StepDir<S, D, N> {
    /// Takes the pins, and sets STEP low and the direction forward.
    pub fn new(pins: [Pins<S, D>; N]) -> Self {
        let mut drive = StepDir { pins };
        drive.end(Axes::MAX);
        for axis in 0..N {
            drive.direction(axis as u8, true);
        }
        drive
    }

    /// Returns the pins.
    pub fn release(self) -> [Pins<S, D>; N] {
        self.pins
    }
}

impl<S: OutputPin, D: OutputPin, const N: usize> Drive for StepDir<S, D, N> {
    #[inline]
    fn begin(&mut self, axes: Axes) {
        for (axis, pins) in self.pins.iter_mut().enumerate() {
            if axes >> axis & 1 != 0 {
                let _ = pins.step.set_high();
            }
        }
    }

    #[inline]
    fn end(&mut self, axes: Axes) {
        for (axis, pins) in self.pins.iter_mut().enumerate() {
            if axes >> axis & 1 != 0 {
                let _ = pins.step.set_low();
            }
        }
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        if let Some(pins) = self.pins.get_mut(usize::from(axis)) {
            let high = forward != pins.invert_direction;
            let _ = pins.direction.set_state(high.into());
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    use embedded_hal_mock::eh1::digital::{Mock, State, Transaction};

    #[test]
    fn only_the_named_axes_move() {
        let pin = |levels: &[State]| {
            Mock::new(&levels.iter().map(|&level| Transaction::set(level)).collect::<Vec<_>>())
        };
        let (low, high) = (State::Low, State::High);
        let steps = [pin(&[low, high, low]), pin(&[low])];
        let directions = [pin(&[high]), pin(&[low, high, low])];
        let [s0, s1] = steps;
        let [d0, d1] = directions;
        let mut drive = StepDir::new([
            Pins { step: s0, direction: d0, invert_direction: false },
            Pins { step: s1, direction: d1, invert_direction: true },
        ]);
        drive.begin(0b01);
        drive.end(0b01);
        drive.direction(1, false);
        drive.direction(1, true);
        drive.direction(7, true); // no such axis: nothing
        for mut pins in drive.release() {
            pins.step.done();
            pins.direction.done();
        }
    }
}
