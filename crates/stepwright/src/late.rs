//! When a step is late: one rule for all players and all measurements.

use crate::units::{Rate, Ticks};

/// How many µs after the middle of its interval a step may come and still be on time.
const GRACE: u32 = 1;

/// How many ticks after its deadline a step is late: half the interval to the next deadline (for
/// the last step: from the previous one), plus 1 µs.
///
/// After half an interval a motor still finds its next step ahead of it. The 1 µs is added because
/// above some 100,000 steps/s half an interval is no longer than a player needs for the step of
/// another axis.
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
