//! The change of an acceleration per second, in thousandths of a step.

use super::OutOfRange;
use super::speed::{thousandths, times_1000};
use core::fmt;

/// A jerk without a sign: 0.001 … 10¹⁵ steps/s³, held in 0.001 steps/s³.
///
/// At the largest jerk, the largest acceleration is reached in 0.1 µs.
///
/// ```
/// use stepwright::Jerk;
/// assert_eq!(Jerk::from_steps(400_000).unwrap().to_string(), "400000");
/// assert!(Jerk::from_steps(0).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Jerk(u64);

impl Jerk {
    /// 10¹⁵ steps/s³.
    pub const MAX: Jerk = Jerk(1_000_000_000_000_000_000);
    /// 0.001 steps/s³.
    pub const MIN: Jerk = Jerk(1);

    /// A jerk in whole steps per second cubed, as a compile-time constant: 1 to 10¹⁵. Any other
    /// value does not compile.
    ///
    /// ```
    /// use stepwright::Jerk;
    /// const LIMIT: Jerk = Jerk::of::<400_000>();
    /// assert_eq!(Ok(LIMIT), Jerk::from_steps(400_000));
    /// ```
    ///
    /// ```compile_fail
    /// let jerk = stepwright::Jerk::of::<0>();
    /// ```
    pub const fn of<const STEPS_PER_SECOND_3: u64>() -> Jerk {
        const {
            let fits = STEPS_PER_SECOND_3 >= 1 && STEPS_PER_SECOND_3 <= 1_000_000_000_000_000;
            assert!(fits, "a jerk is 1 to 10¹⁵ steps/s³");
        }
        Jerk(const { STEPS_PER_SECOND_3 * 1000 })
    }

    /// A jerk in whole steps per second cubed.
    ///
    /// # Errors
    /// [`OutOfRange`] unless 1 ≤ `j` ≤ 10¹⁵.
    pub const fn from_steps(j: u64) -> Result<Jerk, OutOfRange> {
        Jerk::from_millisteps(j.saturating_mul(1000))
    }

    /// The jerk nearest to `j` steps/s³ that is allowed: at least 1.
    pub const fn clamped(j: u32) -> Jerk {
        Jerk(times_1000(if j == 0 { 1 } else { j }))
    }

    /// A jerk in thousandths of a step per second cubed.
    ///
    /// # Errors
    /// [`OutOfRange`] unless 1 ≤ `j` ≤ 10¹⁸.
    pub const fn from_millisteps(j: u64) -> Result<Jerk, OutOfRange> {
        if j == 0 || j > Jerk::MAX.0 {
            return Err(OutOfRange {
                what: "jerk",
                min: 0,
                max: 1_000_000_000_000_000,
                unit: "steps/s³, and not 0",
            });
        }
        Ok(Jerk(j))
    }

    /// Thousandths of a step per second cubed.
    pub const fn millisteps(self) -> u64 {
        self.0
    }
}

impl fmt::Display for Jerk {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        thousandths(f, self.0)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    #[test]
    fn edges_are_checked_once() {
        assert!(Jerk::from_millisteps(0).is_err());
        assert_eq!(Jerk::from_steps(1_000_000_000_000_000), Ok(Jerk::MAX));
        assert!(Jerk::from_steps(1_000_000_000_000_001).is_err());
        let error = Jerk::from_steps(u64::MAX).unwrap_err();
        assert_eq!(
            error.to_string(),
            "jerk out of range: 0 to 1000000000000000 steps/s³, and not 0"
        );
        assert_eq!(Jerk::from_millisteps(1_500).unwrap().to_string(), "1.5");
    }
}
