//! What to do when something goes wrong, and why a cycle can't start.

use core::fmt;

/// A motor has come to an end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AtEnd {
    /// Its program is over; the others go on.
    StopMotor,
    /// All programs are over.
    #[default]
    Cancel,
}

/// A delay is below the motor's smallest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AtSmallDelay {
    /// The smallest is taken instead.
    Fix,
    /// The motor's program is over; the others go on.
    StopMotor,
    /// All programs are over, or the cycle does not start.
    #[default]
    Cancel,
}

/// A step came late, or the handler took longer than a fixed tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AtTiming {
    /// Late steps are caught up as the engine does it.
    Ignore,
    /// All programs are over.
    #[default]
    Cancel,
}

/// What to do when something goes wrong; by default the cycle is cancelled,
/// whatever it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strategies {
    /// At a closed switch (`hard_end_handle_strategy`).
    pub hard_end: AtEnd,
    /// At a bound (`soft_end_handle_strategy`).
    pub soft_end: AtEnd,
    /// At a delay that is too small (`small_step_delay_handle_strategy`).
    pub small_delay: AtSmallDelay,
    /// At a late step (`cycle_timing_exceed_handle_strategy`).
    pub timing: AtTiming,
}

impl Strategies {
    /// The cycle is cancelled, whatever it is.
    pub const CANCEL: Strategies = Strategies {
        hard_end: AtEnd::Cancel,
        soft_end: AtEnd::Cancel,
        small_delay: AtSmallDelay::Cancel,
        timing: AtTiming::Cancel,
    };
}

impl Default for Strategies {
    fn default() -> Strategies {
        Strategies::CANCEL
    }
}

/// Why a cycle ended before its programs were done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CycleError {
    /// A motor has a fault, by which its strategy cancels the cycle
    /// (`CYCLE_ERROR_MOTOR_ERROR`).
    MotorError {
        /// Which motor.
        motor: u8,
    },
    /// Steps came late, or the handler took longer than a fixed tick
    /// (`CYCLE_ERROR_HANDLER_TIMING_EXCEEDED`).
    TimingExceeded,
}

impl fmt::Display for CycleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CycleError::MotorError { motor } => {
                write!(f, "an error of motor {}", u16::from(*motor) + 1)
            }
            CycleError::TimingExceeded => f.write_str("steps came late"),
        }
    }
}

/// Why something was refused. Nothing has moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// A cycle is running.
    Running,
    /// No cycle is running, or it is not in the state for this.
    NotRunning,
    /// No motor has a program.
    Nothing,
    /// There is no such motor.
    NoMotor,
    /// The motor's smallest delay is less than three fixed ticks
    /// (`CYCLE_ERROR_TIMER_PERIOD_TOO_LONG`).
    PeriodTooLong {
        /// Which motor.
        motor: u8,
        /// The least smallest delay on this clock, in µs.
        needs: u32,
    },
    /// The motor's smallest delay is no multiple of the fixed tick
    /// (`CYCLE_ERROR_TIMER_PERIOD_ALIQUANT_STEP_DELAY`).
    PeriodAliquant {
        /// Which motor.
        motor: u8,
        /// The next smallest delay on this clock, in µs.
        needs: u32,
    },
    /// The motor's steps are planned to a tick of the timer: not for the fixed
    /// tick.
    NeedsDeadlines {
        /// Which motor.
        motor: u8,
    },
    /// The first delay of a motor is below its smallest, and the strategy is to
    /// cancel.
    SmallDelay {
        /// Which motor.
        motor: u8,
        /// Its smallest, in µs.
        needs: u32,
    },
    /// Faster than this board can step with so many motors moving.
    TooFast {
        /// Which motor.
        motor: u8,
        /// The least delay for it beside the others, in µs.
        needs: u32,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Refusal::Running => f.write_str("a cycle is running; wait, or finish it first"),
            Refusal::NotRunning => f.write_str("no cycle is running"),
            Refusal::Nothing => f.write_str("no motor has anything to do: prepare one first"),
            Refusal::NoMotor => f.write_str("there is no such motor"),
            Refusal::PeriodTooLong { motor, needs } => write!(
                f,
                "the fixed tick is too long for motor {}: a step takes three ticks, so its \
                 smallest delay must be at least {needs} µs",
                u16::from(motor) + 1
            ),
            Refusal::PeriodAliquant { motor, needs } => write!(
                f,
                "the smallest delay of motor {} is no multiple of the fixed tick: the next one \
                 is {needs} µs",
                u16::from(motor) + 1
            ),
            Refusal::NeedsDeadlines { motor } => write!(
                f,
                "what motor {} does needs deadlines: no fixed tick places its steps",
                u16::from(motor) + 1
            ),
            Refusal::SmallDelay { motor, needs } => write!(
                f,
                "the first delay of motor {} is below its smallest: at least {needs} µs",
                u16::from(motor) + 1
            ),
            Refusal::TooFast { motor, needs } => write!(
                f,
                "too fast for this board: motor {} needs delays of at least {needs} µs beside \
                 the others",
                u16::from(motor) + 1
            ),
        }
    }
}

impl core::error::Error for Refusal {}
