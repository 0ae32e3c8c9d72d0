//! When a step is late: one rule for every player, and for who measures them.

use crate::units::{Rate, Ticks};

/// µs that a step may come after the middle of its interval and is still on time.
const GRACE: u32 = 1;

/// Ticks after its deadline at which a step is late: half the interval to the next deadline
/// (of the last step: from the one before), and 1 µs.
///
/// Half an interval, as a motor then still finds its next step ahead; the µs, as above some
/// 100,000 steps/s half an interval is no more than what any player needs for another axis's
/// step.
///
/// ```
/// use stepwright::{Rate, late_after};
///
/// // 1,000 steps/s on an Uno's timer: 500 µs and 1.
/// assert_eq!(late_after(16_000, Rate::from_hz(16_000_000)?), 8_016);
/// # Ok::<(), stepwright::OutOfRange>(())
/// ```
pub const fn late_after(interval: Ticks, rate: Rate) -> Ticks {
    interval / 2 + rate.hz() / 1_000_000 * GRACE
}
