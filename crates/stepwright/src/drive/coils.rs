//! Windings on one port: the step interrupt writes the next row of a table.

use super::{Axes, Drive, Port, Sequence};

/// One motor whose lines are on one port and set in one write.
///
/// The phase is kept through a stop. A program that stores [`phase`](Coils::phase) and restores it
/// at power-up finds the motor where it was (Austin).
///
/// ```
/// use stepwright::drive::{Coils, Port, sequence};
/// # #[derive(Default)] struct Pins(u8);
/// # impl Port for Pins {
/// #     fn set(&mut self, mask: u8) { self.0 |= mask }
/// #     fn clear(&mut self, mask: u8) { self.0 &= !mask }
/// # }
/// // The motor shield on an Uno: D12 and D13 are bits 4 and 5 of port B.
/// let mut motor = Coils::new(Pins::default(), sequence::SHIELD.on_bits(&[4, 5]), 0b0011_0000);
/// motor.on();
/// motor.step();
/// assert_eq!(motor.port().0, 0b0001_0000);
/// ```
#[derive(Debug)]
pub struct Coils<P> {
    port: P,
    sequence: Sequence,
    mask: u8,
    phase: u8,
    forward: bool,
}

impl<P: Port> Coils<P> {
    /// A motor at phase 0 without current. `sequence` is arranged by the port's bits; `mask` is the
    /// motor's bits.
    pub const fn new(port: P, sequence: Sequence, mask: u8) -> Coils<P> {
        Coils { port, sequence, mask, phase: 0, forward: true }
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
    #[inline(always)]
    pub fn step(&mut self) {
        self.phase = self.sequence.after(self.phase, self.forward);
        self.write(self.sequence.levels(self.phase));
    }

    /// Sets the direction: forward, or backward, through the table.
    #[inline]
    pub fn set_forward(&mut self, forward: bool) {
        self.forward = forward;
    }

    /// The row of the table at which the motor is.
    pub const fn phase(&self) -> u8 {
        self.phase
    }

    /// Sets the row at which the motor is, without a step: at power-up.
    pub fn restore(&mut self, phase: u8) {
        self.phase = phase & self.sequence.len().wrapping_sub(1);
    }

    /// Whether the current must go off after the last step.
    pub const fn rests(&self) -> bool {
        self.sequence.rests()
    }

    /// The port.
    pub fn port(&mut self) -> &mut P {
        &mut self.port
    }

    #[inline(always)]
    fn write(&mut self, levels: u8) {
        self.port.write(self.mask, levels);
    }
}

/// The motor is the engine's only axis.
impl<P: Port> Drive for Coils<P> {
    #[inline]
    fn begin(&mut self, axes: Axes) {
        if axes & 1 != 0 {
            self.step();
        }
    }

    #[inline]
    fn end(&mut self, _: Axes) {}

    fn direction(&mut self, axis: u8, forward: bool) {
        if axis == 0 {
            self.set_forward(forward);
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::sequence;
    use super::*;
    use std::vec::Vec;

    fn motor(sequence: Sequence) -> Coils<u8> {
        Coils::new(0b1100_0000, sequence.on_bits(&[0, 1, 2, 3, 4, 5]), 0b0011_1111)
    }

    #[test]
    fn backwards_is_the_way_back() {
        let mut motor = motor(sequence::UNIPOLAR_HALF);
        motor.on();
        let mut there = Vec::new();
        for _ in 0..11 {
            there.push(*motor.port());
            motor.step();
        }
        motor.set_forward(false);
        for levels in there.iter().rev() {
            motor.step();
            assert_eq!(motor.port(), levels);
        }
        assert_eq!(motor.phase(), 0);
        assert_eq!(*motor.port() & 0b1100_0000, 0b1100_0000, "others' pins");
    }

    #[test]
    fn current_on_at_the_start_and_off_after_the_last_step() {
        let mut motor = motor(sequence::L6219_QUARTER);
        motor.off();
        let off = *motor.port();
        motor.on();
        let on = *motor.port();
        for _ in 0..7 {
            motor.step();
        }
        motor.off();
        assert_eq!(*motor.port(), off);
        assert_eq!(off & 0b0011_1100, 0b0011_1100, "all four I high: no current");
        assert_ne!(on & 0b0011_1100, 0b0011_1100);
        // The phase survives the stop, and power-up if it is stored.
        assert_eq!(motor.phase(), 7);
        motor.on();
        let held = *motor.port();
        let mut other = self::motor(sequence::L6219_QUARTER);
        other.restore(motor.phase());
        other.on();
        assert_eq!(*other.port(), held);
        other.restore(200); // any number is a phase
        assert_eq!(other.phase(), 200 & 15);
    }

    #[test]
    fn the_engine_steps_its_axis_only() {
        let mut motor = motor(sequence::UNIPOLAR_FULL);
        motor.begin(0b10);
        assert_eq!(motor.phase(), 0);
        motor.begin(0b11);
        motor.end(0b11);
        assert_eq!(motor.phase(), 1);
        motor.direction(1, false);
        motor.begin(1);
        assert_eq!(motor.phase(), 2);
        motor.direction(0, false);
        motor.begin(1);
        assert_eq!(motor.phase(), 1);
    }
}
