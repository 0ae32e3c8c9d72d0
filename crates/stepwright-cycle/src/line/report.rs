//! The state of a cycle, over the line.

use super::fault::refusal;
use stepwright_protocol::Numbers;

use crate::strategy::{CycleError, Refusal};

/// The answer to `:?`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CycleReport {
    /// Whether a cycle runs, and whether it is paused.
    pub running: bool,
    /// See `running`.
    pub paused: bool,
    /// The number of the last cycle that was started.
    pub number: u8,
    /// Ticks from its start to now or to its end.
    pub time: u64,
    /// Why it was cancelled.
    pub error: Option<CycleError>,
    /// Its late steps.
    pub late: u32,
    /// The longest time of the handler in the cycle, in µs.
    pub longest: u32,
    /// When it was paused, resumed and finished, in ticks after its start.
    pub acts: [Option<u64>; 3],
    /// Homing: 0 none, 1 in progress, 2 done; 3 the switch was not found, 4 it is still closed, 5
    /// cancelled, 16 and more: refused, with the refusal's code added.
    pub home: u8,
    /// The delay that homing needs, if it was refused for a delay, in µs.
    pub needs: u32,
    /// The motors.
    pub motors: [MotorReport; 8],
    /// The number of motors.
    pub count: u8,
}

/// The state of a motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotorReport {
    /// 0 idle, 1 running, 2 finished.
    pub status: u8,
    /// Its [faults](crate::Faults).
    pub faults: u8,
    /// When the last of these came, in ticks after the start.
    pub fault_at: Option<u64>,
    /// Its position.
    pub position: i64,
    /// Whether its position is unknown after a kill or a reset.
    pub uncertain: bool,
    /// Its greatest position, if it has one; reported when no cycle runs.
    pub max: Option<i64>,
}

impl CycleReport {
    /// Numbers before those of the motors.
    pub const HEAD: u8 = 11;
    /// Numbers of a motor.
    pub const EACH: u8 = 5;

    /// Parses an answer; `None` if it is no report.
    pub fn read(text: &[u8]) -> Option<CycleReport> {
        let mut numbers = Numbers::of(text);
        let mut next = || numbers.next();
        let state = next()?;
        let number = u8::try_from(next()?).ok()?;
        let time = u64::try_from(next()?).ok()?;
        let error = match next()? {
            0 => None,
            1 => Some(CycleError::TimingExceeded),
            motor => Some(CycleError::MotorError { motor: u8::try_from(motor - 2).ok()? }),
        };
        let [late, longest] = [u32::try_from(next()?).ok()?, u32::try_from(next()?).ok()?];
        // The time plus 1, or 0.
        let moment = |number: i64| Some(u64::try_from(number).ok()?.checked_sub(1));
        let acts = [moment(next()?)?, moment(next()?)?, moment(next()?)?];
        let (home, needs) = (u8::try_from(next()?).ok()?, u32::try_from(next()?).ok()?);
        let mut motors = [MotorReport::default(); 8];
        let mut count = 0;
        while let Some(status) = next() {
            let motor = motors.get_mut(usize::from(count))?;
            let ends = status & 4 != 0;
            (motor.status, motor.uncertain) = ((status & 3) as u8, status & 8 != 0);
            motor.faults = u8::try_from(next()?).ok()?;
            motor.fault_at = moment(next()?)?;
            motor.position = next()?;
            let max = next()?;
            motor.max = ends.then_some(max);
            count += 1;
        }
        let (running, paused) = (state != 0, state == 2);
        let report = CycleReport {
            running,
            paused,
            number,
            time,
            error,
            late,
            longest,
            acts,
            home,
            needs,
            motors,
            count,
        };
        (numbers.is_end() && count > 0).then_some(report)
    }

    /// Why homing was refused, if it was.
    pub fn home_refusal(&self, motor: u8) -> Option<Refusal> {
        refusal(self.home.checked_sub(16)?, motor, self.needs)
    }
}
