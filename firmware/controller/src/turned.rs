//! The directions of the axes.

use core::sync::atomic::{AtomicU8, Ordering};

use stepwright::drive::Axes;

/// The axes that turn the other way round, and the axes that face backward: together they determine
/// the levels of the DIR pins. The step interrupt sets the directions, the main loop sets the axes
/// that turn the other way.
pub struct Turned {
    reversed: AtomicU8,
    backward: AtomicU8,
}

impl Turned {
    /// No axis turns the other way round, all face forward.
    pub const fn new() -> Turned {
        Turned { reversed: AtomicU8::new(0), backward: AtomicU8::new(0) }
    }

    /// Sets the direction of an axis. Returns the level of its DIR.
    #[inline(always)]
    pub fn direction(&self, axis: u8, forward: bool) -> bool {
        let bit = 1u8.wrapping_shl(axis.into());
        let backward = self.backward.load(Ordering::Relaxed) & !bit;
        self.backward.store(backward | if forward { 0 } else { bit }, Ordering::Relaxed);
        forward == (self.reversed.load(Ordering::Relaxed) & bit == 0)
    }

    /// Sets the axes that turn the other way round. Returns the levels of all DIR, a bit each.
    /// Called while all axes rest.
    pub fn reverse(&self, axes: Axes) -> Axes {
        self.reversed.store(axes, Ordering::Relaxed);
        !(axes ^ self.backward.load(Ordering::Relaxed))
    }
}

impl Default for Turned {
    fn default() -> Self {
        Turned::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_that_is_turned_round_has_the_other_level() {
        let turned = Turned::new();
        assert!(turned.direction(0, true) && !turned.direction(1, false));
        // Axis 2 has had no direction yet: it faces forward.
        assert_eq!(turned.reverse(0b110) & 0b111, 0b011);
        assert!(turned.direction(1, false) && !turned.direction(2, true));
        assert_eq!(turned.reverse(0) & 0b111, 0b101);
    }
}
