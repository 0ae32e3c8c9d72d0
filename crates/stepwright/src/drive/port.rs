//! Step and direction where all pins lie on one port: one write moves all.

use super::{Axes, Drive};

/// An output port of up to 8 pins, written as a whole.
pub trait Port {
    /// Sets the pins in `mask` high, and leaves the others alone.
    fn set(&mut self, mask: u8);
    /// Sets the pins in `mask` low, and leaves the others alone.
    fn clear(&mut self, mask: u8);
    /// Sets the pins in `mask` to their bits of `levels`, and leaves the others alone. A
    /// chip that can do so in one write should: what was high and falls, falls at once
    /// with what rises.
    #[inline(always)]
    fn write(&mut self, mask: u8, levels: u8) {
        self.clear(mask & !levels);
        self.set(mask & levels);
    }
}

/// Step/direction drivers whose STEP pins lie side by side on one port.
///
/// On the Uno with a CNC shield X, Y, Z step on D2, D3, D4 = port D, bits 2 to
/// 4: axis 0 is bit `step_shift` = 2, and three axes step in the same cycle.
#[derive(Debug)]
pub struct PortDrive<P> {
    port: P,
    step_shift: u8,
    direction_shift: u8,
    /// Axes whose forward is a low DIR.
    inverted: Axes,
}

impl<P: Port> PortDrive<P> {
    /// Axis i has STEP at bit `step_shift` + i and DIR at `direction_shift` + i.
    /// Bits that would lie beyond the port are ignored.
    pub fn new(port: P, step_shift: u8, direction_shift: u8, inverted: Axes) -> PortDrive<P> {
        PortDrive {
            port,
            step_shift: step_shift.min(7),
            direction_shift: direction_shift.min(7),
            inverted,
        }
    }

    /// Gives the port back.
    pub fn release(self) -> P {
        self.port
    }
}

impl<P: Port> Drive for PortDrive<P> {
    #[inline]
    fn begin(&mut self, axes: Axes) {
        self.port.set(axes << self.step_shift);
    }

    #[inline]
    fn end(&mut self, axes: Axes) {
        self.port.clear(axes << self.step_shift);
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        let bit = 1u8.checked_shl(axis.into()).unwrap_or(0);
        let mask = bit << self.direction_shift;
        if forward != (self.inverted & bit != 0) {
            self.port.set(mask);
        } else {
            self.port.clear(mask);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Port for u8 {
        fn set(&mut self, mask: u8) {
            *self |= mask;
        }
        fn clear(&mut self, mask: u8) {
            *self &= !mask;
        }
    }

    #[test]
    fn three_axes_step_in_one_write() {
        let mut drive = PortDrive::new(0b0000_0001u8, 2, 5, 0b010);
        drive.begin(0b111);
        assert_eq!(drive.port, 0b0001_1101);
        drive.end(0b101);
        assert_eq!(drive.port, 0b0000_1001);
        drive.direction(0, true);
        drive.direction(1, true);
        drive.direction(2, true);
        drive.direction(200, true);
        assert_eq!(drive.port, 0b1010_1001);
    }
}
