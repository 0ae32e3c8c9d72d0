//! Step and direction with all pins on one port: one write sets them all.

use super::{Axes, Drive};

/// An output port of up to 8 pins, written as a whole.
pub trait Port {
    /// Sets the pins in `mask` high; leaves the others unchanged.
    fn set(&mut self, mask: u8);
    /// Sets the pins in `mask` low; leaves the others unchanged.
    fn clear(&mut self, mask: u8);
    /// Sets the pins in `mask` to their bits of `levels`; leaves the others unchanged. A chip that
    /// can do this in one write should, so that pins fall and rise at the same time.
    #[inline(always)]
    fn write(&mut self, mask: u8, levels: u8) {
        self.clear(mask & !levels);
        self.set(mask & levels);
    }
}

/// Step/direction drivers whose STEP pins are adjacent bits of one port.
///
/// On the Uno with a CNC shield, the STEP pins of X, Y and Z are D2, D3 and D4: port D, bits 2 to
/// 4. Axis 0 is bit `step_shift` = 2, and three axes step in the same cycle.
#[derive(Debug)]
pub struct PortDrive<P> {
    port: P,
    step_shift: u8,
    direction_shift: u8,
    /// Axes for which a low DIR means forward.
    inverted: Axes,
}

impl<P: Port> PortDrive<P> {
    /// Axis i has STEP at bit `step_shift` + i and DIR at bit `direction_shift` + i. Bits beyond
    /// the port are ignored.
    pub fn new(port: P, step_shift: u8, direction_shift: u8, inverted: Axes) -> PortDrive<P> {
        PortDrive {
            port,
            step_shift: step_shift.min(7),
            direction_shift: direction_shift.min(7),
            inverted,
        }
    }

    /// Returns the port.
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
