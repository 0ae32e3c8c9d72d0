//! The rows of motor cycles on a board's line, both sides: a line, its answer.
//!
//! ```text
//!   host   :W0,26,29,8,9,255*hh␍     board   Y*hh␍        motor 0 on D2, D5, D8, D9
//!          :M0,7500,1000,0,0,0,0,0*hh␍       Y*hh␍        7500 nm a step, 1000 µs and more
//!          :S0,0,20000,1000*hh␍              Y*hh␍        20,000 steps, 1000 µs each
//!          :G1*hh␍                           Y*hh␍        go
//!          V1*hh␍                            4500000*hh␍  axis 1 is motor 0
//! ```
//!
//! Frame, checksum and the rows `?`, `F`, `V`, `I`, `Z`, `K` are every program's
//! ([`stepwright_protocol`]); these are the cycles' own. Axes are counted from 1, motors from 0.
//! `Z` and `K` finish the cycle: every motor stops at once, with `Z` its position is known. Each
//! line may be said twice: the second one changes nothing. Delays are in µs, times in ticks of the
//! timer.
//!
//! | line | numbers | |
//! | --- | --- | --- |
//! | `:N` | | all that was prepared is forgotten |
//! | `:C` | tick in µs, 0: deadlines; at a hard end 0: stop the motor, 1: brake it, 2: cancel, 3: brake all; at a soft end 0: stop the motor, 1: cancel; at a small delay 0: fix, 1: stop the motor, 2: cancel; late 0: ignore, 1: cancel | the clock and the [strategies](super::Strategies) |
//! | `:W` | motor, pins of STEP, DIR, ENABLE, switch at the minimum and at the maximum | a pin is 8 · its port, A being 0, and its bit; 255: there is none |
//! | `:M` | motor, distance of a step, smallest delay, inverted, steps/s² to brake by, which ends it has (1: minimum, 2: maximum), minimum, maximum | the [motor](super::Motor) |
//! | `:P` | motor, position | it is there |
//! | `:S` | motor, calibration, count, delay | steps |
//! | `:H` | motor, calibration, forward, delay | steps without end |
//! | `:D` | motor, calibration, count, from, to, by | steps by a [ramp](super::DelayRamp) of delays |
//! | `:R` | motor, calibration, forward, from, to, by | the same without end |
//! | `:A` | place, count, delay | a leg: steps |
//! | `:B` | place, count, delay | a leg: a wait |
//! | `:X` | place, count, interval in 2⁻¹⁶ ticks, by how much each differs from the one before | a leg: steps that were planned elsewhere, at most 65,535; none: a wait |
//! | `:L` | motor, calibration, first place, how many | a series of these legs |
//! | `:T` | 0: pause, 1: resume, 2: finish; ticks after the start | what is to happen on the way |
//! | `:G` | a number of the cycle, 1 to 255 | go; the number of the present cycle is no second one |
//! | `:U` | number, motor, end (0: minimum), reach, steps to back off, fast, slow delay | [home](super::Homing) |
//! | `:Q`, `:O` | | pause, go on: now |
//! | `:?` | | the numbers of [`CycleReport`] |
//!
//! All but `:?` is answered `Y`, or `E` and a reason ([`CycleFault`]). While a cycle runs only
//! `:Q`, `:O`, `:?` and its own `:G` or `:U` are taken of these. In the answer to `?`, `can=` has
//! what the board can of `brakes`, `home`, `paths` (the row `:X`) and `tick`, and `legs=` how many
//! legs it keeps.

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

/// The longest line that is read, in bytes, its checksum included.
pub const LONGEST: usize = 84;
/// How the answer to `?` begins.
pub const NAME: &str = "stepwright-cycle";

/// A row of the cycles, or `Z`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CycleLine {
    /// `:N`: forget what was prepared.
    New,
    /// `:C`: the clock, and what to do when something goes wrong.
    Clock(Clock, Strategies),
    /// `:W`: the pins of a motor.
    Wire(u8, MotorPins),
    /// `:M`: a motor.
    Motor(u8, Motor),
    /// `:P`: its position.
    Position(u8, i64),
    /// `:S`, `:H`, `:D`, `:R`, `:L`: what a motor does in the next cycle.
    Prepare(u8, Calibration, LineProgram),
    /// `:A`, `:B`, `:X`: a leg of a series, at its place.
    Leg(u16, Leg),
    /// `:T`: what is to happen this many ticks after the start.
    Act(LineAct, u64),
    /// `:G`: go.
    Start(u8),
    /// `:U`: home.
    Home(u8, Homing),
    /// `:Q`, `:O`, `Z`: now.
    Now(LineAct),
    /// `:?`: how is it?
    Look,
}

/// What happens to a cycle while it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineAct {
    /// It is held up.
    Pause,
    /// It goes on.
    Resume,
    /// It ends.
    Finish,
}

impl LineAct {
    /// All of them, in the order of their numbers.
    pub const ALL: [LineAct; 3] = [LineAct::Pause, LineAct::Resume, LineAct::Finish];
}

/// What a motor does: a [`Program`](super::Program) without a borrow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineProgram {
    /// A count of steps, backward if negative.
    Steps {
        /// How many.
        count: i32,
        /// µs from step to step.
        delay: u32,
    },
    /// Steps without end.
    Whirl {
        /// Which way.
        forward: bool,
        /// µs from step to step.
        delay: u32,
    },
    /// Steps by a ramp of delays.
    Ramp {
        /// How many; without end if it is not said.
        steps: Option<u32>,
        /// Which way.
        forward: bool,
        /// The delays.
        ramp: DelayRamp,
    },
    /// Legs of the store.
    Legs {
        /// The first one's place.
        first: u16,
        /// How many.
        count: u16,
    },
}

/// The pins of a motor, as a line has them: 8 · port + bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MotorPins {
    /// STEP, DIR, ENABLE (low turns the driver on), the switches at the minimum and at the
    /// maximum (low is closed); [`NO_PIN`](MotorPins::NO_PIN) for what is not there.
    pub codes: [u8; 5],
}

impl MotorPins {
    /// There is no such pin.
    pub const NO_PIN: u8 = 0xFF;
    /// Nothing is wired.
    pub const NONE: MotorPins = MotorPins { codes: [MotorPins::NO_PIN; 5] };
}

#[cfg(test)]
mod tests;
