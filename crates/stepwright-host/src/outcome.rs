//! The limits of a motion, the outcome of an order, and why an order is not carried out.

use std::fmt;

use stepwright::{Accel, Jerk, OutOfRange, Speed};
use stepwright_protocol::{Command, Order, Ramp, Refusal, Stop, Travel};

use crate::conversation::LinkError;
use crate::home::NotHomed;
use crate::homing::HomingFailure;
use crate::link::OpenError;
use crate::motion::NotBegun;

/// The limits of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotionLimits {
    /// The speed that the motor reaches from rest in one step, and may stop from: 0 … 1,000,000 steps/s.
    pub start: Speed,
    /// The speed between the ramps: 0.001 … 1,000,000 steps/s.
    pub top: Speed,
    /// The acceleration up to the top speed: 1 … 100,000,000 steps/s².
    pub accel: Accel,
    /// The deceleration back down.
    pub decel: Accel,
    /// The jerk limit, for a board that has S-curves.
    pub jerk: Option<Jerk>,
}

impl MotionLimits {
    /// From rest to this speed and back, with this acceleration.
    pub const fn new(top: Speed, accel: Accel) -> MotionLimits {
        MotionLimits { start: Speed::ZERO, top, accel, decel: accel, jerk: None }
    }

    pub(crate) fn order(&self, travel: Travel) -> Order {
        let MotionLimits { start, top, accel, decel, jerk } = *self;
        Order { start, top, up: Ramp::Accel(accel), down: Ramp::Accel(decel), jerk, travel }
    }
}

impl Default for MotionLimits {
    /// 1,000 steps/s, reached after 200 steps from a start speed of 50 steps/s.
    fn default() -> MotionLimits {
        const fn speed(steps: u32) -> Speed {
            match Speed::from_steps(steps) {
                Ok(speed) => speed,
                Err(_) => Speed::MAX,
            }
        }
        const ACCEL: Accel = match Accel::from_steps(2_494) {
            Ok(accel) => accel,
            Err(_) => panic!("an acceleration"),
        };
        MotionLimits { start: speed(50), ..MotionLimits::new(speed(1_000), ACCEL) }
    }
}

/// The outcome of an order. One that did not reach its target is no error: look at it.
#[must_use = "an axis that was stopped is no error"]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The axis rests at its target.
    Reached {
        /// The position, in steps.
        at: i64,
    },
    /// The axis rests at another position.
    Stopped {
        /// The position, in steps.
        at: i64,
        /// The reason, if the board tells it.
        reason: Option<Stop>,
    },
    /// The position is unknown: a kill, or a similar stop, may have lost steps.
    Uncertain,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Outcome::Reached { at } => write!(f, "reached {at}"),
            Outcome::Stopped { at, reason: Some(stop) } => {
                write!(f, "stopped at {at} by {}", stop.words())
            }
            Outcome::Stopped { at, reason: None } => write!(f, "stopped at {at}"),
            Outcome::Uncertain => f.write_str("position uncertain"),
        }
    }
}

/// Why an order was not carried out, or is not known to have been. `Debug` is the text of `Display`, which a
/// program shows that ends with this error.
pub enum Error {
    /// The port can't be opened.
    Open(OpenError),
    /// The conversation has ended.
    Lost {
        /// Why.
        trouble: LinkError,
        /// Whether a motor may be moving.
        moving: bool,
    },
    /// The board has no axis of this number.
    NoAxis {
        /// The number of its axes.
        axes: u8,
    },
    /// A number is outside its range.
    Range(OutOfRange),
    /// The travel is too long: the most is 2³¹ − 1 steps.
    TooFar {
        /// The number of steps asked for.
        steps: i64,
    },
    /// The board refused this line, which has moved nothing.
    Refused {
        /// The line.
        line: Command,
        /// The reason, if the board tells it.
        reason: Option<Refusal>,
    },
    /// Noise spoiled every attempt to give the order, which has moved nothing.
    Noise,
    /// The axis moves: wait for the end of the travel, stop the axis, or change its travel.
    Moving,
    /// The position of the axis is unknown: home it, or make its position 0.
    Uncertain,
    /// Where the travel began is unknown: another program began it.
    BeginUnknown,
    /// The board has no limit switch for the axis: the setting `switches` names the switches.
    NoSwitch,
    /// The axis is not homed.
    NotHomed(HomingFailure),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Open(error) => error.fmt(f),
            Error::Lost { trouble, moving: false } => trouble.fmt(f),
            Error::Lost { trouble, moving: true } => write!(f, "{trouble}; a motor may be moving"),
            Error::NoAxis { axes } => write!(f, "no such axis: give 1 to {axes}"),
            Error::Range(range) => range.fmt(f),
            Error::TooFar { steps } => {
                write!(f, "{steps} steps are too far for one travel: at most 2147483647")
            }
            // Every line that we say is a line of the protocol.
            Error::Refused { line, reason: Some(Refusal::Line) } => write!(
                f,
                "{line} was refused: the board has no such line, or a program that holds its port \
                 takes questions, changes and stops alone"
            ),
            Error::Refused { line, reason: Some(why) } => write!(f, "{line} was refused: {why}"),
            Error::Refused { line, reason: None } => write!(f, "{line} was refused"),
            Error::Noise => f.write_str("every attempt was spoiled by noise; nothing has moved"),
            Error::Moving => {
                f.write_str("the axis moves: wait for it, stop it, or change its travel")
            }
            Error::Uncertain => {
                f.write_str("the position is uncertain: home the axis, or set its position")
            }
            Error::BeginUnknown => f.write_str(
                "where the travel began is not known: say with retarget_by how far from there it is to go",
            ),
            Error::NoSwitch => {
                f.write_str("the board knows of no limit switch of this axis (setting switches)")
            }
            Error::NotHomed(failure) => write!(f, "not homed: {failure}"),
        }
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Error {}

impl From<OutOfRange> for Error {
    fn from(range: OutOfRange) -> Error {
        Error::Range(range)
    }
}

/// Whether a motor moves is unknown.
impl From<LinkError> for Error {
    fn from(trouble: LinkError) -> Error {
        Error::Lost { trouble, moving: true }
    }
}

impl From<NotBegun> for Error {
    fn from(not: NotBegun) -> Error {
        match not {
            NotBegun::Refused(line, reason) => Error::Refused { line, reason },
            NotBegun::Trouble { trouble, moving } => Error::Lost { trouble, moving },
            NotBegun::Noise => Error::Noise,
        }
    }
}

impl From<NotHomed> for Error {
    fn from(not: NotHomed) -> Error {
        match not {
            NotHomed::NotBegun(not) => not.into(),
            NotHomed::Unsayable(range) => Error::Range(range),
            NotHomed::Failed(failure, _) => Error::NotHomed(failure),
            NotHomed::Trouble(trouble) => Error::Lost { trouble, moving: false },
            NotHomed::Adrift(trouble) => Error::Lost { trouble, moving: true },
        }
    }
}
