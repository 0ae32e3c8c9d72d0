//! Writes a line as it is sent.

use core::fmt;

use super::{CycleLine, LineAct, LineProgram, MotorPins};
use crate::clock::Clock;
use crate::homing::Homing;
use crate::motor::{End, Motor};
use crate::program::{DelayRamp, Leg};
use crate::strategy::{AtHardEnd, AtSmallDelay, AtSoftEnd, AtTiming, Strategies};

/// Writes a row: its letter and its numbers.
fn write(f: &mut fmt::Formatter<'_>, letter: char, numbers: &[i64]) -> fmt::Result {
    write!(f, ":{letter}")?;
    let mut comma = "";
    for number in numbers {
        write!(f, "{comma}{number}")?;
        comma = ",";
    }
    Ok(())
}

/// The row as it is sent, without its checksum and carriage return.
impl fmt::Display for CycleLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            CycleLine::New => write(f, 'N', &[]),
            CycleLine::Look => write(f, '?', &[]),
            CycleLine::Now(LineAct::Pause) => write(f, 'Q', &[]),
            CycleLine::Now(LineAct::Resume) => write(f, 'O', &[]),
            // A row of all programs.
            CycleLine::Now(LineAct::Finish) => f.write_str("Z"),
            CycleLine::Clock(clock, Strategies { hard_end, soft_end, small_delay, timing }) => {
                let tick = match clock {
                    Clock::Deadlines => 0,
                    Clock::Tick { period } | Clock::Grid { period } => period.max(1),
                };
                let hard = match hard_end {
                    AtHardEnd::StopMotor => 0,
                    AtHardEnd::BrakeMotor => 1,
                    AtHardEnd::Cancel => 2,
                    AtHardEnd::BrakeAll => 3,
                };
                let small = match small_delay {
                    AtSmallDelay::Fix => 0,
                    AtSmallDelay::StopMotor => 1,
                    AtSmallDelay::Cancel => 2,
                };
                let soft = (soft_end == AtSoftEnd::Cancel).into();
                let late = (timing == AtTiming::Cancel).into();
                write(f, 'C', &[tick.into(), hard, soft, small, late])
            }
            CycleLine::Wire(motor, MotorPins { codes: [a, b, c, d, e] }) => {
                write(f, 'W', &[motor, a, b, c, d, e].map(i64::from))
            }
            CycleLine::Motor(motor, what) => {
                let Motor { distance, smallest_delay, inverted, min, max, decel } = what;
                let ends = i64::from(min.is_some()) + 2 * i64::from(max.is_some());
                let (min, max) = (min.unwrap_or(0), max.unwrap_or(0));
                let [motor, distance, delay] = [motor.into(), distance, smallest_delay];
                let first = [motor, distance, delay, inverted.into(), decel].map(i64::from);
                let [a, b, c, d, e] = first;
                write(f, 'M', &[a, b, c, d, e, ends, min, max])
            }
            CycleLine::Position(motor, at) => write(f, 'P', &[motor.into(), at]),
            CycleLine::Prepare(motor, calibration, program) => {
                let (motor, kind) = (motor.into(), calibration as i64);
                match program {
                    LineProgram::Steps { count, delay } => {
                        write(f, 'S', &[motor, kind, count.into(), delay.into()])
                    }
                    LineProgram::Whirl { forward, delay } => {
                        write(f, 'H', &[motor, kind, forward.into(), delay.into()])
                    }
                    LineProgram::Ramp { steps, forward, ramp: DelayRamp { from, to, by } } => {
                        let [from, to, by] = [from, to, by].map(i64::from);
                        let (letter, count) = match (steps, forward) {
                            (None, forward) => ('R', forward.into()),
                            (Some(steps), true) => ('D', steps.into()),
                            (Some(steps), false) => ('D', -i64::from(steps)),
                        };
                        write(f, letter, &[motor, kind, count, from, to, by])
                    }
                    LineProgram::Legs { first, count } => {
                        write(f, 'L', &[motor, kind, first.into(), count.into()])
                    }
                }
            }
            CycleLine::Leg(at, Leg::Steps { count, delay }) => {
                write(f, 'A', &[at.into(), count.into(), delay.into()])
            }
            CycleLine::Leg(at, Leg::Wait { count, delay }) => {
                write(f, 'B', &[at.into(), count.into(), delay.into()])
            }
            #[cfg(feature = "runs")]
            CycleLine::Leg(at, Leg::Run { run, forward }) => {
                let count = i64::from(run.count());
                let count = if forward { count } else { -count };
                write(f, 'X', &[at.into(), count, run.interval() as i64, run.add().into()])
            }
            CycleLine::Act(act, ticks) => {
                let ticks = i64::try_from(ticks).unwrap_or(i64::MAX);
                write(f, 'T', &[act as i64, ticks])
            }
            CycleLine::Start(number) => write(f, 'G', &[number.into()]),
            CycleLine::Home(number, Homing { motor, end, fast, slow, reach, back_off, .. }) => {
                let end = u32::from(end == End::Max);
                let all = [number.into(), motor.into(), end, reach, back_off, fast, slow];
                write(f, 'U', &all.map(i64::from))
            }
        }
    }
}
