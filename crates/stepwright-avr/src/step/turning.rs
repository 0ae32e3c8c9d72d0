//! Positions where entries turn in the middle of a travel.

use avr_device::interrupt;

use super::{AvrEngine, AxisState, FLAGS, channels, place, pointed, steps};

/// Likewise, with the sign of their way.
const fn signed(steps: u32, backward: bool) -> i64 {
    if backward { (steps as i64).wrapping_neg() } else { steps as i64 }
}

/// Whether DIR turns with these pins.
const fn turns(pins: u8) -> bool {
    pins & channels::STEPS == 0 && pins != 0
}

impl AvrEngine {
    /// Steps made since the travel began, forward less backward: those loaded, less those that are
    /// left of the groups that were.
    #[inline(never)]
    pub(super) fn made(&self, axis: u8) -> i64 {
        let at = pointed(place(axis));
        let (loaded, now, pins, next, then, flags, facing) = interrupt::free(|_| {
            // SAFETY: no interrupt comes, and none refills.
            unsafe {
                let AxisState { loaded, now, next, facing, .. } = &*at;
                let flags = FLAGS.read_volatile();
                (*loaded, now.left, now.pins, next.left, next.pins, flags, *facing)
            }
        });
        let [a, b, c, d, high] = loaded;
        let mut made = i64::from_le_bytes([a, b, c, d, high, 0, 0, 0]) << 24 >> 24;
        let mut backward = facing & 1 != 0;
        if flags >> axis & 1 != 0 {
            made = made.wrapping_sub(signed(steps(next, then), backward));
            backward ^= turns(then);
        }
        made.wrapping_sub(signed(steps(now, pins), backward))
    }
}
