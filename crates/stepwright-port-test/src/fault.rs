//! The faults of a timer.

use core::fmt;

/// How a timer breaks the contract of [`StepTimer`](stepwright::timer::StepTimer). The text says what was
/// seen, what is required and what to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimerFault {
    /// The counter shows the same value at every read.
    StandsStill,
    /// The counter went back.
    Backward,
    /// The interrupt never came.
    Lost {
        /// Ticks from the counter to the compare value when it was set; 0 or less if it had passed.
        ahead: i32,
        /// Ticks after which the test gave up.
        waited: i32,
    },
    /// The interrupt came, and a deadline ahead counted as passed.
    Early {
        /// Ticks from the counter to the compare value when it was set.
        ahead: i32,
        /// By how many ticks the deadline was too early.
        by: i32,
    },
}

impl fmt::Display for TimerFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TimerFault::StandsStill => {
                f.write_str("the counter stands still: start it, and read the register that counts")
            }
            TimerFault::Backward => f.write_str(
                "the counter went back: it has to count up, and to be read in one piece",
            ),
            TimerFault::Lost { ahead, waited } if *ahead > 0 => write!(
                f,
                "no interrupt {waited} ticks after the compare value was set {ahead} ticks ahead: \
                 enable it, and let `wake_at` clear an old request before it looks at the counter"
            ),
            TimerFault::Lost { ahead, waited } => write!(
                f,
                "no interrupt within {waited} ticks for a compare value {} ticks ago: `wake_at` has \
                 to look at the counter once the value is set, and to pend the interrupt if it has \
                 passed",
                ahead.unsigned_abs()
            ),
            TimerFault::Early { ahead, by } => write!(
                f,
                "a deadline {ahead} ticks ahead came {by} ticks early: the counter has to count at \
                 one rate, through all its values"
            ),
        }
    }
}

impl core::error::Error for TimerFault {}
