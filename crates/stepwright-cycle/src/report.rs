//! The state of a cycle: states, faults, positions, times.

use super::{
    Calibration, Cycle, CycleError, End, Faults, MachineIo, Motor, Refusal, State, Status,
};
use stepwright::drive::Drive;
use stepwright::timer::StepTimer;

impl<T: StepTimer, D: Drive, S: MachineIo, const N: usize> Cycle<'_, T, D, S, N> {
    /// Whether a cycle is in progress, paused or not.
    pub fn is_running(&self) -> bool {
        !matches!(self.state, State::Rest)
    }

    /// Whether a cycle is paused.
    pub fn is_paused(&self) -> bool {
        matches!(&self.state, State::Paused(pause) if !pause.resumed)
    }

    /// Why the present or last cycle was cancelled.
    pub fn error(&self) -> Option<CycleError> {
        self.error
    }

    /// The status of a motor; idle if there is no such motor.
    pub fn status(&mut self, motor: u8) -> Status {
        self.player(motor).map_or(Status::Idle, |player| player.status)
    }

    /// The faults of a motor in its last cycle.
    pub fn faults(&mut self, motor: u8) -> Faults {
        self.player(motor).map_or(Faults::NONE, |player| player.faults)
    }

    /// The position of a motor in its unit, also during a cycle; `None` if there is no such motor.
    pub fn position(&mut self, motor: u8) -> Option<i64> {
        let steps = self.steps(motor);
        self.player(motor).map(|player| player.position(steps))
    }

    /// The low 32 bits of a motor's count of steps: a moment, for
    /// [`position_at`](Cycle::position_at).
    pub fn count(&mut self, motor: u8) -> u32 {
        self.steps(motor) as u32
    }

    /// The position of a motor when its step count was `count`, less than 2³¹ steps ago; `None` if
    /// there is no such motor.
    pub fn position_at(&mut self, motor: u8, count: u32) -> Option<i64> {
        let now = self.steps(motor);
        let since = (now as u32).wrapping_sub(count) as i32;
        let then = now.wrapping_sub(since.into());
        self.player(motor).map(|player| player.position(then))
    }

    /// Sets the present position of a motor.
    ///
    /// # Errors
    /// [`Refusal::Running`] while a cycle runs; [`Refusal::NoMotor`].
    pub fn set_position(&mut self, motor: u8, position: i64) -> Result<(), Refusal> {
        if self.is_running() {
            return Err(Refusal::Running);
        }
        let steps = self.steps(motor);
        let player = self.player(motor).ok_or(Refusal::NoMotor)?;
        player.calibration = Calibration::None;
        player.set_position(steps, position);
        Ok(())
    }

    /// A motor, with its calibrated bounds; `None` if there is no such motor.
    pub fn motor(&mut self, motor: u8) -> Option<Motor> {
        let steps = self.steps(motor);
        let running = self.is_running();
        let player = self.player(motor)?;
        let mut known = player.motor;
        if running && player.calibration == Calibration::BoundsMax && player.has_moved(steps) {
            known.max = Some(player.position(steps));
        }
        Some(known)
    }

    /// The position of a motor when its switch last closed.
    pub fn trigger(&self, motor: u8, end: End) -> Option<i64> {
        *self.triggers.get(usize::from(motor))?.get(end as usize)?
    }

    /// Whether a motor's switch is closed now; false if there is none.
    pub fn is_closed(&mut self, motor: u8, end: End) -> bool {
        let now = self.surroundings.switches();
        let side = if end == End::Min { now.min } else { now.max };
        side.checked_shr(motor.into()).unwrap_or(0) & 1 != 0
    }

    /// The longest time of the step interrupt in the present or last cycle, in µs. The hardware's
    /// time to enter it is not included.
    pub fn longest(&self) -> u32 {
        self.beat.micros(self.longest)
    }

    /// Late steps in the present or last cycle.
    pub fn late(&self) -> u32 {
        self.engine.late()
    }

    /// The timer.
    pub fn timer(&mut self) -> &mut T {
        self.engine.timer()
    }

    /// The drive.
    pub fn drive(&mut self) -> &mut D {
        &mut self.engine.drive().drive
    }

    /// The inputs and outputs around the motors.
    pub fn surroundings(&mut self) -> &mut S {
        &mut self.surroundings
    }
}
