//! Homing: to the switch, back, slowly to it again; that is the end.
//!
//! ```text
//!   switch ▔▔▔▔▔│
//!               │◄───────────────── approach, fast
//!               │─────►               back off
//!               │◄─────               approach, slowly
//!               0
//! ```
//!
//! Each is a cycle of its own under [`Calibration::StartMin`], so no soft end is in the way. The
//! motor stops between two steps when the switch closes. If it loses steps by stopping at once from
//! the fast approach, the slow approach corrects that. If it brakes there
//! ([`AtHardEnd`](super::AtHardEnd)), the way back must be longer than the braking distance, and
//! the slow approach slow enough to stop at once: the end is where the motor stands.

use core::fmt;

use super::motor::{Calibration, End, Faults};
use super::program::Program;
use super::strategy::Refusal;
use super::surroundings::MachineIo;
use super::{Cycle, CycleError};
use stepwright::drive::Drive;
use stepwright::timer::StepTimer;

/// How to home a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Homing {
    /// The motor.
    pub motor: u8,
    /// The end.
    pub end: End,
    /// µs from step to step in the first approach and on the way back; 0: the motor's smallest
    /// delay.
    pub fast: u32,
    /// µs from step to step in the second approach.
    pub slow: u32,
    /// The number of steps within which the switch must be found.
    pub reach: u32,
    /// The number of steps back from it; twice as many are made to find it again.
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

/// Why a motor could not be homed. It stands where it was stopped, and its position has no meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomingError {
    /// A cycle of it was refused.
    Refused(Refusal),
    /// The switch was not found within the reach.
    NotFound,
    /// The switch is still closed after the way back.
    StillClosed,
    /// The cycle was cancelled for another reason than the switch.
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
    /// A homing, which [`poll`](Homing::poll) carries out.
    pub const fn new(motor: u8, end: End, reach: u32, back_off: u32) -> Homing {
        Homing { motor, end, fast: 0, slow: 0, reach, back_off, stage: Stage::Begin }
    }

    /// This homing with these delays in µs.
    pub const fn delays(self, fast: u32, slow: u32) -> Homing {
        Homing { fast, slow, ..self }
    }

    /// Continues the homing when no cycle is running; call it regularly in the foreground. Returns
    /// true when it is done: the motor stands at its end, and its position is its minimum or
    /// maximum, or 0 if it has none.
    ///
    /// # Errors
    /// [`HomingError`]; the homing has ended then.
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

    /// Makes a part of the way: this many steps towards the end, or away from it.
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

    /// Checks that the part ended because all steps were made.
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

    /// Checks that the part ended at the switch.
    fn hit<T: StepTimer, D: Drive, S: MachineIo, const N: usize>(
        &self,
        cycle: &mut Cycle<'_, T, D, S, N>,
    ) -> Result<(), HomingError> {
        if cycle.faults(self.motor) == Faults::hard(self.end) {
            return Ok(());
        }
        self.whole(cycle)?;
        // The switch may have closed at the very last step.
        match cycle.is_closed(self.motor, self.end) {
            true => Ok(()),
            false => Err(HomingError::NotFound),
        }
    }
}
