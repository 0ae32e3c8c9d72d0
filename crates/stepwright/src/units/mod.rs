//! The quantities of motion, as types.
//!
//! A value is rounded **once**, on entry, to what the core can represent. From there on all
//! arithmetic is exact, in integers. The representation is decimal, so that a value as a person
//! types it is exact:
//!
//! | type | holds | unit | largest |
//! | --- | --- | --- | --- |
//! | [`Speed`] | `u32` | 0.001 steps/s | 1,000,000 steps/s |
//! | [`Accel`] | `u64` | 0.001 steps/s² | 100,000,000 steps/s² |
//! | [`Jerk`] | `u64` | 0.001 steps/s³ | 10¹⁵ steps/s³ |
//! | [`Rate`] | `u32` | ticks/s of a timer | 200 MHz |
//!
//! Revolutions, radians and millimetres become steps through [`Geometry`].

mod geometry;
mod jerk;
mod speed;

pub use geometry::{Geometry, Turn};
pub use jerk::Jerk;
pub use speed::{Accel, OutOfRange, Speed};

/// A delay or a duration in counts of the step timer.
///
/// `u32`: at 16 MHz up to 268 s, at 200 MHz up to 21 s between two steps.
pub type Ticks = u32;

/// The rate of a step timer in ticks per second: 100 kHz … 200 MHz.
///
/// A value, not a type parameter: the command takes it from a user at run time, and an AVR reads it
/// from its prescaler.
///
/// ```
/// use stepwright::Rate;
/// let uno = Rate::from_hz(16_000_000).unwrap();
/// assert_eq!(uno.micros(10), 160);
/// assert!(Rate::from_hz(50).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Rate(u32);

impl Rate {
    /// The slowest timer for which the closed forms are tested: 100 kHz.
    pub const MIN: Rate = Rate(100_000);
    /// The fastest: 200 MHz.
    pub const MAX: Rate = Rate(200_000_000);
    /// 1 MHz, the timer of Austin and of the `plan` command.
    pub const MHZ: Rate = Rate(1_000_000);

    /// The rate as a compile-time constant: 100,000 to 200,000,000 ticks per second. Any other
    /// value does not compile.
    ///
    /// ```
    /// use stepwright::Rate;
    /// const PICO: Rate = Rate::of::<125_000_000>();
    /// assert_eq!(Ok(PICO), Rate::from_hz(125_000_000));
    /// ```
    ///
    /// ```compile_fail
    /// let rate = stepwright::Rate::of::<50>();
    /// ```
    pub const fn of<const HZ: u32>() -> Rate {
        const {
            let fits = HZ >= Rate::MIN.0 && HZ <= Rate::MAX.0;
            assert!(fits, "a timer has 100,000 to 200,000,000 ticks/s");
        }
        Rate(HZ)
    }

    /// A timer of `hz` ticks per second.
    ///
    /// # Errors
    /// [`OutOfRange`] unless 100,000 ≤ `hz` ≤ 200,000,000.
    pub const fn from_hz(hz: u32) -> Result<Rate, OutOfRange> {
        if hz < Rate::MIN.0 || hz > Rate::MAX.0 {
            return Err(OutOfRange {
                what: "timer rate",
                min: Rate::MIN.0 as u64,
                max: Rate::MAX.0 as u64,
                unit: "Hz",
            });
        }
        Ok(Rate(hz))
    }

    /// Ticks per second.
    pub const fn hz(self) -> u32 {
        self.0
    }

    /// `us` microseconds in ticks, rounded up, so that a pulse or a set-up time is never too short;
    /// saturates.
    pub const fn micros(self, us: u32) -> Ticks {
        self.nanos_wide(us as u64 * 1000)
    }

    /// `ns` nanoseconds in ticks, rounded up; saturates.
    pub const fn nanos(self, ns: u32) -> Ticks {
        self.nanos_wide(ns as u64)
    }

    const fn nanos_wide(self, ns: u64) -> Ticks {
        const SECOND: u64 = 1_000_000_000;
        let hz = self.0 as u64;
        // Splitting off whole seconds keeps both products within 64 bits.
        let ticks = ns / SECOND * hz + (ns % SECOND * hz).div_ceil(SECOND);
        if ticks > Ticks::MAX as u64 { Ticks::MAX } else { ticks as Ticks }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_round_up_and_saturate() {
        let uno = Rate::from_hz(16_000_000).unwrap();
        assert_eq!(uno.nanos(1500), 24);
        assert_eq!(uno.nanos(1), 1);
        assert_eq!(uno.micros(0), 0);
        assert_eq!(Rate::MAX.micros(u32::MAX), Ticks::MAX);
    }

    #[test]
    fn rates_are_checked() {
        assert!(Rate::from_hz(99_999).is_err());
        assert!(Rate::from_hz(100_000).is_ok());
        assert!(Rate::from_hz(200_000_001).is_err());
    }
}
