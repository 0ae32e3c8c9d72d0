//! Positions when entries turn during a travel.

use avr_device::interrupt;

use super::{AvrEngine, AxisState, FLAGS, channels, place, pointed, steps};

/// Steps with the sign of their direction.
const fn signed(steps: u32, backward: bool) -> i64 {
    if backward { (steps as i64).wrapping_neg() } else { steps as i64 }
}

/// Whether a group with these pins turns DIR.
const fn turns(pins: u8) -> bool {
    pins & channels::STEPS == 0 && pins != 0
}

impl AvrEngine {
    /// The steps made since the travel began, forward less backward: the loaded steps less those
    /// left in the present group and in the prepared one.
    #[inline(never)]
    pub(super) fn made(&self, axis: u8) -> i64 {
        let at = pointed(place(axis));
        let (loaded, now, pins, next, then, flags, facing) = interrupt::free(|_| {
            // SAFETY: no interrupt comes, and no refill is in progress.
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
