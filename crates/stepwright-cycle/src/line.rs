//! The rows of motor cycles on a board's line, for both sides: lines and answers.
//!
//! ```text
//!   host   :W0,26,29,8,9,255*hh␍     board   Y*hh␍        motor 0 on D2, D5, D8, D9
//!          :M0,7500,1000,0,0,0,0,0*hh␍       Y*hh␍        7500 nm a step, 1000 µs and more
//!          :S0,0,20000,1000*hh␍              Y*hh␍        20,000 steps, 1000 µs each
//!          :G1*hh␍                           Y*hh␍        go
//!          V1*hh␍                            4500000*hh␍  axis 1 is motor 0
//! ```
//!
//! Frame, checksum and the rows `?`, `F`, `V`, `I`, `Z`, `K` are common to all programs
//! ([`stepwright_protocol`]); these rows are specific to cycles. Axes are counted from 1, motors
//! from 0. `Z` and `K` finish the cycle: every motor stops at once; after `Z` its position is
//! known. Each line may be sent twice: the second one changes nothing. Delays are in µs, times in
//! ticks of the timer.
//!
//! | line | numbers | |
//! | --- | --- | --- |
//! | `:N` | | forgets all that was prepared |
//! | `:C` | tick in µs, 0: deadlines; at a hard end 0: stop the motor, 1: brake it, 2: cancel, 3: brake all; at a soft end 0: stop the motor, 1: cancel; at a small delay 0: fix, 1: stop the motor, 2: cancel; at a late step 0: ignore, 1: cancel | the clock and the [strategies](super::Strategies) |
//! | `:W` | motor, pins of STEP, DIR, ENABLE, switch at the minimum and at the maximum | a pin is 8 · its port, A being 0, plus its bit; 255: none |
//! | `:M` | motor, distance of a step, smallest delay, inverted, braking deceleration in steps/s², the ends that it has (1: minimum, 2: maximum), minimum, maximum | the [motor](super::Motor) |
//! | `:P` | motor, position | sets its position |
//! | `:S` | motor, calibration, count, delay | steps |
//! | `:H` | motor, calibration, forward, delay | steps without end |
//! | `:D` | motor, calibration, count, from, to, by | steps by a [ramp](super::DelayRamp) of delays |
//! | `:R` | motor, calibration, forward, from, to, by | the same without end |
//! | `:A` | place, count, delay | a leg: steps |
//! | `:B` | place, count, delay | a leg: a wait |
//! | `:X` | place, count, interval in 2⁻¹⁶ ticks, growth from one interval to the next | a leg: at most 65,535 steps that were planned elsewhere; 0 steps: a wait |
//! | `:L` | motor, calibration, first place, number of legs | a series of these legs |
//! | `:T` | 0: pause, 1: resume, 2: finish; ticks after the start | an act during the cycle |
//! | `:G` | a number of the cycle, 1 to 255 | starts it; the number of the present cycle starts no second one |
//! | `:U` | number, motor, end (0: minimum), reach, steps to back off, fast, slow delay | [homes](super::Homing) a motor |
//! | `:Q`, `:O` | | pauses, resumes: now |
//! | `:?` | | the numbers of [`CycleReport`] |
//!
//! All rows but `:?` are answered by `Y`, or by `E` and a reason ([`CycleFault`]). While a cycle
//! runs, only `:Q`, `:O`, `:?` and its own `:G` or `:U` are accepted. In the answer to `?`, `can=`
//! lists which of `brakes`, `home`, `paths` (the row `:X`) and `tick` the board supports, and
//! `legs=` is the number of legs that it stores.

mod fault;
mod read;
mod report;
mod write;

pub use fault::CycleFault;
pub(crate) use fault::home_code;
pub(crate) use read::HOMES;
pub use report::{CycleReport, MotorReport};

use super::clock::Clock;
use super::homing::Homing;
use super::motor::{Calibration, Motor};
use super::program::{DelayRamp, Leg};
use super::strategy::Strategies;

/// The longest line that is accepted, in bytes, including its checksum.
pub const LONGEST: usize = 84;
/// The beginning of the answer to `?`.
pub const NAME: &str = "stepwright-cycle";

/// A row of the cycles, or `Z`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CycleLine {
    /// `:N`: forgets what was prepared.
    New,
    /// `:C`: the clock, and the reactions to faults.
    Clock(Clock, Strategies),
    /// `:W`: the pins of a motor.
    Wire(u8, MotorPins),
    /// `:M`: a motor.
    Motor(u8, Motor),
    /// `:P`: the position of a motor.
    Position(u8, i64),
    /// `:S`, `:H`, `:D`, `:R`, `:L`: the program of a motor in the next cycle.
    Prepare(u8, Calibration, LineProgram),
    /// `:A`, `:B`, `:X`: a leg of a series, at its place.
    Leg(u16, Leg),
    /// `:T`: an act this many ticks after the start.
    Act(LineAct, u64),
    /// `:G`: starts the cycle.
    Start(u8),
    /// `:U`: homes a motor.
    Home(u8, Homing),
    /// `:Q`, `:O`, `Z`: an act now.
    Now(LineAct),
    /// `:?`: asks for a report.
    Look,
}

/// An act on a cycle while it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineAct {
    /// Pauses it.
    Pause,
    /// Resumes it.
    Resume,
    /// Ends it.
    Finish,
}

impl LineAct {
    /// All acts, in the order of their numbers.
    pub const ALL: [LineAct; 3] = [LineAct::Pause, LineAct::Resume, LineAct::Finish];
}

/// The program of a motor: a [`Program`](super::Program) without a borrow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineProgram {
    /// A count of steps, backward if negative.
    Steps {
        /// The number of steps.
        count: i32,
        /// µs from step to step.
        delay: u32,
    },
    /// Steps without end.
    Whirl {
        /// The direction.
        forward: bool,
        /// µs from step to step.
        delay: u32,
    },
    /// Steps by a ramp of delays.
    Ramp {
        /// The number of steps; `None`: without end.
        steps: Option<u32>,
        /// The direction.
        forward: bool,
        /// The delays.
        ramp: DelayRamp,
    },
    /// Legs in the board's memory.
    Legs {
        /// The place of the first leg.
        first: u16,
        /// The number of legs.
        count: u16,
    },
}

/// The pins of a motor, as coded in a line: 8 · port + bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotorPins {
    /// STEP, DIR, ENABLE (low enables the driver), the switches at the minimum and at the maximum
    /// (low is closed); [`NO_PIN`](MotorPins::NO_PIN) for a pin that is absent.
    pub codes: [u8; 5],
}

impl MotorPins {
    /// The code for an absent pin.
    pub const NO_PIN: u8 = 0xFF;
    /// No pins.
    pub const NONE: MotorPins = MotorPins { codes: [MotorPins::NO_PIN; 5] };
}

#[cfg(test)]
mod tests;
