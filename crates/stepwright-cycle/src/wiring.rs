//! Between the engine and the drive: inverted directions, and the wide pulse of the fixed tick.

use stepwright::drive::{Axes, Drive};

/// A drive with the motors' inverted directions and the pass that ends a pulse.
///
/// On the fixed tick a pulse lasts from one tick to the next. The engine's event at its end is a
/// turn, possibly to the same side, which lowers STEP.
pub(crate) struct Wiring<D> {
    pub drive: D,
    /// Axes whose direction is inverted.
    pub inverted: Axes,
    /// Whether pulses last until the next turn.
    pub wide: bool,
    /// Axes whose STEP is high, while pulses are wide.
    pub raised: Axes,
    /// Axes whose direction was set, and those of them that face forward.
    told: Axes,
    facing: Axes,
}

impl<D: Drive> Wiring<D> {
    pub(crate) const fn new(drive: D, inverted: Axes, wide: bool) -> Wiring<D> {
        Wiring { drive, inverted, wide, raised: 0, told: 0, facing: 0 }
    }

    /// Ends the wide pulses of these axes.
    pub(crate) fn lower(&mut self, axes: Axes) {
        let axes = axes & self.raised;
        if axes != 0 {
            self.raised &= !axes;
            self.drive.end(axes);
        }
    }

    /// Sets whether an axis is inverted; its direction is `forward` now.
    pub(crate) fn set_inverted(&mut self, axis: u8, inverted: bool, forward: bool) {
        let bit = 1u8.checked_shl(axis.into()).unwrap_or(0);
        if inverted != (self.inverted & bit != 0) {
            self.inverted ^= bit;
            self.tell_again(axis, forward);
        }
    }

    /// Sets the direction of an axis again.
    pub(crate) fn tell_again(&mut self, axis: u8, forward: bool) {
        self.told &= !1u8.checked_shl(axis.into()).unwrap_or(0);
        self.direction(axis, forward);
    }
}

impl<D: Drive> Drive for Wiring<D> {
    #[inline]
    fn begin(&mut self, axes: Axes) {
        self.drive.begin(axes);
        if self.wide {
            self.raised |= axes;
        }
    }

    #[inline]
    fn end(&mut self, axes: Axes) {
        if !self.wide {
            self.drive.end(axes);
        }
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        let bit = 1u8.checked_shl(axis.into()).unwrap_or(0);
        self.lower(bit);
        if self.told & bit == 0 || forward != (self.facing & bit != 0) {
            self.told |= bit;
            self.facing = if forward { self.facing | bit } else { self.facing & !bit };
            self.drive.direction(axis, forward != (self.inverted & bit != 0));
        }
    }
}
