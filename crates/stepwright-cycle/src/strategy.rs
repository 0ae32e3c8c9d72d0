//! The reactions to faults, and the reasons to refuse a cycle.

use core::fmt;

/// The reaction when a motor reaches a switch. The motor counts every step that it makes, also
/// while it brakes, so its position stays exact. A calibration uses the place where the motor
/// stands; [`Cycle::trigger`](super::Cycle::trigger) returns that of the switch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AtHardEnd {
    /// It stops at once, and its program ends; the others continue.
    StopMotor,
    /// It brakes at its [deceleration](super::Motor::decel), and its program ends when it stands;
    /// the others continue. Needs the feature `brakes`: [`NoBrakes`](Refusal::NoBrakes) without it.
    BrakeMotor,
    /// All motors stop at once; all programs end.
    #[default]
    Cancel,
    /// All motors brake, each at its own deceleration, and all programs end when the last one
    /// stands. Needs the feature `brakes`, too.
    BrakeAll,
}

impl AtHardEnd {
    /// Whether motors brake.
    pub const fn brakes(self) -> bool {
        matches!(self, AtHardEnd::BrakeMotor | AtHardEnd::BrakeAll)
    }
}

/// The reaction when a motor reaches a bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AtSoftEnd {
    /// Its program ends; the others continue.
    StopMotor,
    /// All programs end.
    #[default]
    Cancel,
}

/// The reaction to a delay below the motor's smallest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AtSmallDelay {
    /// The smallest delay is used instead.
    Fix,
    /// The motor's program ends; the others continue.
    StopMotor,
    /// All programs end, or the cycle does not start.
    #[default]
    Cancel,
}

/// The reaction to a late step, or to a handler that took longer than a fixed tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AtTiming {
    /// The engine catches up late steps.
    Ignore,
    /// All programs end.
    #[default]
    Cancel,
}

/// The reactions to faults; by default any fault cancels the cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strategies {
    /// At a closed switch (`hard_end_handle_strategy`).
    pub hard_end: AtHardEnd,
    /// At a bound (`soft_end_handle_strategy`).
    pub soft_end: AtSoftEnd,
    /// At a delay that is too small (`small_step_delay_handle_strategy`).
    pub small_delay: AtSmallDelay,
    /// At late steps (`cycle_timing_exceed_handle_strategy`).
    pub timing: AtTiming,
}

impl Strategies {
    /// Any fault cancels the cycle.
    pub const CANCEL: Strategies = Strategies {
        hard_end: AtHardEnd::Cancel,
        soft_end: AtSoftEnd::Cancel,
        small_delay: AtSmallDelay::Cancel,
        timing: AtTiming::Cancel,
    };
}

impl Default for Strategies {
    fn default() -> Strategies {
        Strategies::CANCEL
    }
}

/// Why a cycle ended before its programs were complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CycleError {
    /// A motor has a fault that cancels the cycle, according to its strategy
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

/// Why a call was refused. Nothing has moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// A cycle is running.
    Running,
    /// No cycle is running, or it is in the wrong state.
    NotRunning,
    /// No motor has a program.
    Nothing,
    /// The motor does not exist.
    NoMotor,
    /// The motor's smallest delay is less than three fixed ticks
    /// (`CYCLE_ERROR_TIMER_PERIOD_TOO_LONG`).
    PeriodTooLong {
        /// Which motor.
        motor: u8,
        /// The smallest value for the smallest delay with this clock, in µs.
        needs: u32,
    },
    /// The motor's smallest delay is not a multiple of the fixed tick
    /// (`CYCLE_ERROR_TIMER_PERIOD_ALIQUANT_STEP_DELAY`).
    PeriodAliquant {
        /// Which motor.
        motor: u8,
        /// The next possible smallest delay with this clock, in µs.
        needs: u32,
    },
    /// The motor's steps are planned to a tick of the timer, which the fixed tick can't play.
    NeedsDeadlines {
        /// Which motor.
        motor: u8,
    },
    /// The first delay of a motor is below its smallest, and the strategy is to cancel.
    SmallDelay {
        /// Which motor.
        motor: u8,
        /// Its smallest delay, in µs.
        needs: u32,
    },
    /// Braking at a switch was asked for, but is not compiled into this board's program (feature
    /// `brakes`).
    NoBrakes,
    /// The fixed tick was asked for, but is not compiled into this board's program (feature
    /// `tick`).
    NoTick,
    /// The motor's program was planned elsewhere, but support for it is not compiled into this
    /// board's program (feature `paced`).
    NoPaths {
        /// Which motor.
        motor: u8,
    },
    /// The motor should brake at its switch, but has no deceleration.
    NeedsDecel {
        /// Which motor.
        motor: u8,
    },
    /// Faster than this board can step with this many motors moving.
    TooFast {
        /// Which motor.
        motor: u8,
        /// The smallest delay for it beside the others, in µs.
        needs: u32,
    },
}

impl Refusal {
    /// The motor that is the reason, if there is one.
    pub const fn motor(&self) -> Option<u8> {
        match *self {
            Refusal::Running
            | Refusal::NotRunning
            | Refusal::Nothing
            | Refusal::NoMotor
            | Refusal::NoTick
            | Refusal::NoBrakes => None,
            Refusal::NoPaths { motor }
            | Refusal::PeriodTooLong { motor, .. }
            | Refusal::PeriodAliquant { motor, .. }
            | Refusal::NeedsDeadlines { motor }
            | Refusal::NeedsDecel { motor }
            | Refusal::SmallDelay { motor, .. }
            | Refusal::TooFast { motor, .. } => Some(motor),
        }
    }

    /// The text of the refusal with a name for the motor; without one it is "motor 1" and so on.
    ///
    /// ```
    /// use stepwright_cycle::Refusal;
    /// let refusal = Refusal::SmallDelay { motor: 1, needs: 600 };
    /// let said = refusal.named("Y").to_string();
    /// assert_eq!(said, "the first delay of Y is below its smallest: at least 600 µs");
    /// assert!(refusal.to_string().starts_with("the first delay of motor 2 is"));
    /// ```
    pub fn named(self, name: impl fmt::Display) -> impl fmt::Display {
        Named { refusal: self, name }
    }
}

/// A refusal for a motor with a name.
struct Named<M> {
    refusal: Refusal,
    name: M,
}

/// A motor without a name: counted from 1.
struct Number(u8);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "motor {}", u16::from(self.0) + 1)
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Named { refusal: *self, name: Number(self.motor().unwrap_or(0)) }.fmt(f)
    }
}

impl<M: fmt::Display> fmt::Display for Named<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = &self.name;
        match self.refusal {
            Refusal::Running => f.write_str("a cycle is running; wait, or finish it first"),
            Refusal::NotRunning => f.write_str("no cycle is running"),
            Refusal::Nothing => f.write_str("no motor has anything to do: prepare one first"),
            Refusal::NoMotor => f.write_str("there is no such motor"),
            Refusal::PeriodTooLong { needs, .. } => write!(
                f,
                "the fixed tick is too long for {name}: a step takes three ticks, so its \
                 smallest delay must be at least {needs} µs"
            ),
            Refusal::PeriodAliquant { needs, .. } => write!(
                f,
                "the smallest delay of {name} is no multiple of the fixed tick: the next one \
                 is {needs} µs"
            ),
            Refusal::NeedsDeadlines { .. } => {
                write!(f, "what {name} does needs deadlines: no fixed tick places its steps")
            }
            Refusal::NoBrakes => f.write_str(
                "this board has no room for braking at a switch: stop at once, or cancel",
            ),
            Refusal::NoTick => {
                f.write_str("this board has no room for the fixed tick: leave tick-us out")
            }
            Refusal::NoPaths { .. } => {
                write!(f, "this board has no room for a line or an arc, which {name} is to follow")
            }
            Refusal::NeedsDecel { .. } => write!(
                f,
                "{name} is to brake at its switch and has no deceleration: give it one, or let it \
                 stop at once"
            ),
            Refusal::SmallDelay { needs, .. } => {
                write!(f, "the first delay of {name} is below its smallest: at least {needs} µs")
            }
            Refusal::TooFast { needs, .. } => write!(
                f,
                "too fast for this board: {name} needs delays of at least {needs} µs beside the \
                 others"
            ),
        }
    }
}

impl core::error::Error for Refusal {}
