//! Parses a line and checks every number of it.

#[cfg(feature = "runs")]
use stepwright::run::Run;

use stepwright_protocol::Numbers;

use super::{CycleLine, LineAct, LineProgram, MotorPins};
use crate::clock::Clock;
use crate::homing::Homing;
use crate::motor::{Calibration, End, Motor};
use crate::program::{DelayRamp, Leg};
use crate::strategy::{AtHardEnd, AtSmallDelay, AtSoftEnd, AtTiming, Strategies};

/// Whether the board can home by itself.
pub(crate) const HOMES: bool = cfg!(feature = "homing");
/// The longest fixed tick in µs.
const TICK: u32 = 1_000_000;

impl CycleLine {
    /// Parses the row with this letter and these numbers, for a board with this many motors and
    /// legs; `None` if there is no such row.
    pub fn read(letter: u8, n: &mut Numbers<'_>, motors: u8, legs: u16) -> Option<CycleLine> {
        parse(letter, n, motors, legs)
    }
}

/// Parses a row with this letter.
#[inline(always)]
fn parse(letter: u8, n: &mut Numbers<'_>, motors: u8, legs: u16) -> Option<CycleLine> {
    let line = match letter {
        b'N' => CycleLine::New,
        b'?' => CycleLine::Look,
        b'Q' => CycleLine::Now(LineAct::Pause),
        b'O' => CycleLine::Now(LineAct::Resume),
        b'G' => CycleLine::Start(n.between(1, 255)? as u8),
        b'C' => {
            let clock = match n.between(0, TICK)? {
                0 => Clock::Deadlines,
                period => Clock::Grid { period },
            };
            CycleLine::Clock(clock, strategies(n)?)
        }
        b'T' => {
            let act = match n.up_to(2)? {
                0 => LineAct::Pause,
                1 => LineAct::Resume,
                _ => LineAct::Finish,
            };
            let ticks = n.next()?;
            match u64::try_from(ticks) {
                Ok(ticks) => CycleLine::Act(act, ticks),
                Err(_) => return n.range(0, i64::MAX),
            }
        }
        b'A' | b'B' => {
            let at = n.between(0, u32::from(legs).saturating_sub(1))? as u16;
            let leg = match letter {
                b'A' => Leg::Steps { count: n.count()?, delay: n.word()? },
                _ => Leg::Wait { count: n.word()?, delay: n.word()? },
            };
            CycleLine::Leg(at, leg)
        }
        #[cfg(feature = "runs")]
        b'X' => {
            let at = n.between(0, u32::from(legs).saturating_sub(1))? as u16;
            CycleLine::Leg(at, planned(n)?)
        }
        b'U' if HOMES => {
            let number = n.between(1, 255)? as u8;
            let motor = n.up_to(motors.saturating_sub(1))?;
            let end = if n.up_to(1)? == 0 { End::Min } else { End::Max };
            let homing = Homing::new(motor, end, n.word()?, n.word()?);
            CycleLine::Home(number, homing.delays(n.word()?, n.word()?))
        }
        b'W' | b'M' | b'P' | b'S' | b'H' | b'D' | b'R' | b'L' => {
            let motor = n.up_to(motors.saturating_sub(1))?;
            match letter {
                b'W' => {
                    let mut pins = MotorPins::NONE;
                    for code in &mut pins.codes {
                        *code = n.up_to(MotorPins::NO_PIN)?;
                    }
                    CycleLine::Wire(motor, pins)
                }
                b'M' => CycleLine::Motor(motor, read_motor(n)?),
                b'P' => CycleLine::Position(motor, n.next()?),
                _ => {
                    let calibration = match n.up_to(2)? {
                        0 => Calibration::None,
                        1 => Calibration::StartMin,
                        _ => Calibration::BoundsMax,
                    };
                    CycleLine::Prepare(motor, calibration, program(letter, n, legs)?)
                }
            }
        }
        _ => return None,
    };
    Some(line)
}

/// Parses a leg of steps that were planned elsewhere, or of a wait.
#[cfg(feature = "runs")]
#[inline(never)]
fn planned(n: &mut Numbers<'_>) -> Option<Leg> {
    let signed = n.count()?;
    let Ok(count) = u16::try_from(signed.unsigned_abs()) else {
        return n.range(-i64::from(u16::MAX), u16::MAX.into());
    };
    // A wait of half the range of ticks, which no player takes for one that has passed.
    let most = (1 << 47) - 1;
    let interval = n.next()?;
    if !(0..=most).contains(&interval) {
        return n.range(0, most);
    }
    let growth = n.count()?;
    let last = i64::from(growth).wrapping_mul(count.saturating_sub(1).into());
    if count > 1 && !(0..=most).contains(&interval.wrapping_add(last)) {
        let parts = i64::from(count.wrapping_sub(1));
        return n.range(-(interval / parts), (most - interval) / parts);
    }
    let forward = signed >= 0;
    let run = match count {
        0 => Run::turn((interval >> 16) as u32, forward),
        count => Run::new(interval as u64, growth, count),
    };
    Some(Leg::Run { run, forward })
}

#[inline(never)]
fn strategies(n: &mut Numbers<'_>) -> Option<Strategies> {
    Some(Strategies {
        hard_end: match n.up_to(3)? {
            0 => AtHardEnd::StopMotor,
            1 => AtHardEnd::BrakeMotor,
            2 => AtHardEnd::Cancel,
            _ => AtHardEnd::BrakeAll,
        },
        soft_end: if n.flag()? { AtSoftEnd::Cancel } else { AtSoftEnd::StopMotor },
        small_delay: match n.up_to(2)? {
            0 => AtSmallDelay::Fix,
            1 => AtSmallDelay::StopMotor,
            _ => AtSmallDelay::Cancel,
        },
        timing: if n.flag()? { AtTiming::Cancel } else { AtTiming::Ignore },
    })
}

#[inline(never)]
fn read_motor(n: &mut Numbers<'_>) -> Option<Motor> {
    let mut motor = Motor::new(n.between(1, u32::MAX)?, n.between(1, u32::MAX)?);
    motor.inverted = n.flag()?;
    motor.decel = n.word()?;
    let ends = n.up_to(3)?;
    let (min, max) = (n.next()?, n.next()?);
    motor.min = (ends & 1 != 0).then_some(min);
    motor.max = (ends & 2 != 0).then_some(max);
    if ends == 3 && min > max {
        return n.range(min, i64::MAX);
    }
    Some(motor)
}

#[inline(never)]
fn program(letter: u8, n: &mut Numbers<'_>, legs: u16) -> Option<LineProgram> {
    Some(match letter {
        b'S' => LineProgram::Steps { count: n.count()?, delay: n.word()? },
        b'H' => LineProgram::Whirl { forward: n.flag()?, delay: n.word()? },
        b'D' => {
            let count = n.count()?;
            let steps = Some(count.unsigned_abs());
            LineProgram::Ramp { steps, forward: count >= 0, ramp: ramp(n)? }
        }
        b'R' => LineProgram::Ramp { steps: None, forward: n.flag()?, ramp: ramp(n)? },
        _ => {
            let first = n.between(0, legs.into())?;
            let count = n.between(0, u32::from(legs).saturating_sub(first))?;
            LineProgram::Legs { first: first as u16, count: count as u16 }
        }
    })
}

fn ramp(n: &mut Numbers<'_>) -> Option<DelayRamp> {
    Some(DelayRamp { from: n.word()?, to: n.word()?, by: n.word()? })
}
