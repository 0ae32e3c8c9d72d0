//! Homing: to the switch, away from it, slowly to it again, and there is the end.
//!
//! ```text
//!   switch ▔▔▔▔▔│
//!               │◄───────────────── approach, fast
//!               │─────►               back off
//!               │◄─────               approach, slowly
//!               0
//! ```
//!
//! Each is a cycle of its own under [`Calibration::StartMin`], so no soft end is
//! in the way. The motor stops between two steps where the switch closes; what it
//! loses by stopping dead from the fast approach, the slow one finds again. If it is
//! to brake there ([`AtHardEnd`](super::AtHardEnd)), the way back must be longer than
//! that, and the slow approach slow enough to stop at once: the end is where it stands.

use core::fmt;

use super::motor::{Calibration, End, Faults};
use super::program::Program;
use super::strategy::Refusal;
use super::surroundings::MachineIo;
use super::{Cycle, CycleError};
use stepwright::drive::Drive;
use stepwright::timer::StepTimer;

/// How a motor is homed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Homing {
    /// Which motor.
    pub motor: u8,
    /// To which end.
    pub end: End,
    /// µs from step to step of the first approach and the way back; 0: the
    /// motor's smallest.
    pub fast: u32,
    /// µs from step to step of the second approach.
    pub slow: u32,
    /// Steps within which the switch must be found.
    pub reach: u32,
    /// Steps back from it, and twice as many to find it again.
    pub back_off: u32,
    stage: Stage,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Begin,
    Approach,
    BackOff,
    Slow,
    Done,
}

/// Why a motor could not be homed. It stands where it was stopped, and its
/// position means nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomingError {
    /// A part of it was refused.
    Refused(Refusal),
    /// The switch was not found within the reach.
    NotFound,
    /// The switch is still closed after the way back.
    StillClosed,
    /// The cycle was cancelled, by something else than the switch.
    Cancelled(Faults, Option<CycleError>),
}

impl fmt::Display for HomingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            HomingError::Refused(refusal) => refusal.fmt(f),
            HomingError::NotFound => {
                f.write_str("the switch was not found: is it connected, and the reach long enough?")
            }
            HomingError::StillClosed => {
                f.write_str("the switch is still closed after backing off: back off further")
            }
            HomingError::Cancelled(faults, _) => write!(f, "stopped on the way: {faults}"),
        }
    }
}

impl core::error::Error for HomingError {}

impl From<Refusal> for HomingError {
    fn from(refusal: Refusal) -> HomingError {
        HomingError::Refused(refusal)
    }
}

impl Homing {
    /// To be [polled](Homing::poll).
    pub const fn new(motor: u8, end: End, reach: u32, back_off: u32) -> Homing {
        Homing { motor, end, fast: 0, slow: 0, reach, back_off, stage: Stage::Begin }
    }

    /// The same with these delays in µs.
    pub const fn delays(self, fast: u32, slow: u32) -> Homing {
        Homing { fast, slow, ..self }
    }

    /// Goes on with it, when the cycle is not running: for the foreground, now
    /// and then. True when it is done: the motor stands at its end, which is its
    /// minimum or maximum, or 0 if it has none.
    ///
    /// # Errors
    /// [`HomingError`]; it is over then.
    pub fn poll<T: StepTimer, D: Drive, S: MachineIo, const N: usize>(
        &mut self,
        cycle: &mut Cycle<'_, T, D, S, N>,
    ) -> Result<bool, HomingError> {
        if cycle.is_running() {
            return Ok(false);
        }
        let result = self.step(cycle);
        if result.is_err() {
            self.stage = Stage::Done;
        }
        result
    }

    fn step<T: StepTimer, D: Drive, S: MachineIo, const N: usize>(
        &mut self,
        cycle: &mut Cycle<'_, T, D, S, N>,
    ) -> Result<bool, HomingError> {
        let twice = self.back_off.saturating_mul(2);
        match self.stage {
            Stage::Begin => self.go(cycle, Stage::Approach, self.reach, true, self.fast)?,
            Stage::Approach => {
                self.hit(cycle)?;
                self.go(cycle, Stage::BackOff, self.back_off, false, self.fast)?;
            }
            Stage::BackOff => {
                self.whole(cycle)?;
                if cycle.is_closed(self.motor, self.end) {
                    return Err(HomingError::StillClosed);
                }
                self.go(cycle, Stage::Slow, twice, true, self.slow)?;
            }
            Stage::Slow => {
                self.hit(cycle)?;
                let motor = cycle.motor(self.motor).ok_or(Refusal::NoMotor)?;
                let end = if self.end == End::Min { motor.min } else { motor.max };
                cycle.set_position(self.motor, end.unwrap_or(0))?;
                self.stage = Stage::Done;
            }
            Stage::Done => {}
        }
        Ok(self.stage == Stage::Done)
    }

    /// A part of the way: this many steps towards the end, or away from it.
    fn go<T: StepTimer, D: Drive, S: MachineIo, const N: usize>(
        &mut self,
        cycle: &mut Cycle<'_, T, D, S, N>,
        stage: Stage,
        steps: u32,
        towards: bool,
        delay: u32,
    ) -> Result<(), Refusal> {
        let count = i32::try_from(steps).unwrap_or(i32::MAX);
        let count = if towards == (self.end == End::Max) { count } else { -count };
        cycle.prepare(self.motor, Program::Steps { count, delay }, Calibration::StartMin)?;
        cycle.start()?;
        self.stage = stage;
        Ok(())
    }

    /// The part ended because all steps were made.
    fn whole<T: StepTimer, D: Drive, S: MachineIo, const N: usize>(
        &self,
        cycle: &mut Cycle<'_, T, D, S, N>,
    ) -> Result<(), HomingError> {
        let (faults, error) = (cycle.faults(self.motor), cycle.error());
        match (faults.is_none(), error) {
            (true, None) => Ok(()),
            _ => Err(HomingError::Cancelled(faults, error)),
        }
    }

    /// The part ended at the switch.
    fn hit<T: StepTimer, D: Drive, S: MachineIo, const N: usize>(
        &self,
        cycle: &mut Cycle<'_, T, D, S, N>,
    ) -> Result<(), HomingError> {
        if cycle.faults(self.motor) == Faults::hard(self.end) {
            return Ok(());
        }
        self.whole(cycle)?;
        // It may have closed at the very last step.
        match cycle.is_closed(self.motor, self.end) {
            true => Ok(()),
            false => Err(HomingError::NotFound),
        }
    }
}
