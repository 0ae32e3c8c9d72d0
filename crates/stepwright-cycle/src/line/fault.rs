//! Why a line is refused: numbers behind an `E`.

use core::fmt;

use super::numbers::Numbers;
use crate::strategy::Refusal;

/// Why a line is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineFault {
    /// `E0`: it is none, or has another count of numbers.
    Unknown,
    /// `E1`: its checksum is that of another line.
    Sum,
    /// `E2,number,least,most`: a number, counted from 1, is out of its range.
    Range {
        /// Which number of the line, from 1.
        number: u8,
        /// The least it may be.
        least: i64,
        /// The most.
        most: i64,
    },
    /// `E3,number`: the pin of this number of the line is not the board's, or another motor's.
    Pin {
        /// Which number of the line, from 1.
        number: u8,
    },
    /// `E4,code,motor,needs`: the cycle refuses.
    Refused(Refusal),
}

impl LineFault {
    /// Its numbers, of which the first says what it is.
    pub fn numbers(&self) -> [i64; 4] {
        match *self {
            LineFault::Unknown => [0, 0, 0, 0],
            LineFault::Sum => [1, 0, 0, 0],
            LineFault::Range { number, least, most } => [2, number.into(), least, most],
            LineFault::Pin { number } => [3, number.into(), 0, 0],
            LineFault::Refused(refusal) => {
                let (code, needs) = code(refusal);
                [4, code.into(), refusal.motor().unwrap_or(0).into(), needs.into()]
            }
        }
    }

    /// Reads an answer, without its `E`.
    pub fn read(text: &[u8]) -> Option<LineFault> {
        let mut numbers = Numbers::of(text);
        let mut next = || numbers.next();
        let all = [next()?, next()?, next()?, next()?];
        let number = u8::try_from(all[1]).ok()?;
        Some(match all[0] {
            0 => LineFault::Unknown,
            1 => LineFault::Sum,
            2 => LineFault::Range { number, least: all[2], most: all[3] },
            3 => LineFault::Pin { number },
            4 => {
                let (motor, needs) = (u8::try_from(all[2]).ok()?, u32::try_from(all[3]).ok()?);
                LineFault::Refused(refusal(number, motor, needs)?)
            }
            _ => return None,
        })
    }
}

impl fmt::Display for LineFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LineFault::Unknown => f.write_str("it does not know the line"),
            LineFault::Sum => f.write_str("the line was spoiled on its way"),
            LineFault::Range { number, least, most } => {
                write!(f, "number {number} of the line is {least} to {most}")
            }
            LineFault::Pin { number } => {
                write!(f, "the pin of number {number} is not its own, or another motor's")
            }
            LineFault::Refused(refusal) => refusal.fmt(f),
        }
    }
}

/// A refusal's number, and the delay that would do.
fn code(refusal: Refusal) -> (u8, u32) {
    match refusal {
        Refusal::Running => (0, 0),
        Refusal::NotRunning => (1, 0),
        Refusal::Nothing => (2, 0),
        Refusal::NoMotor => (3, 0),
        Refusal::PeriodTooLong { needs, .. } => (4, needs),
        Refusal::PeriodAliquant { needs, .. } => (5, needs),
        Refusal::NeedsDeadlines { .. } => (6, 0),
        Refusal::SmallDelay { needs, .. } => (7, needs),
        Refusal::NoBrakes => (8, 0),
        Refusal::NeedsDecel { .. } => (9, 0),
        Refusal::TooFast { needs, .. } => (10, needs),
        Refusal::NoTick => (11, 0),
        Refusal::NoPaths { .. } => (12, 0),
    }
}

/// And back.
pub(super) fn refusal(code: u8, motor: u8, needs: u32) -> Option<Refusal> {
    Some(match code {
        0 => Refusal::Running,
        1 => Refusal::NotRunning,
        2 => Refusal::Nothing,
        3 => Refusal::NoMotor,
        4 => Refusal::PeriodTooLong { motor, needs },
        5 => Refusal::PeriodAliquant { motor, needs },
        6 => Refusal::NeedsDeadlines { motor },
        7 => Refusal::SmallDelay { motor, needs },
        8 => Refusal::NoBrakes,
        9 => Refusal::NeedsDecel { motor },
        10 => Refusal::TooFast { motor, needs },
        11 => Refusal::NoTick,
        12 => Refusal::NoPaths { motor },
        _ => return None,
    })
}

/// Homing's number in a report, of a refusal.
pub(crate) fn home_code(refused: Refusal) -> (u8, u32) {
    let (code, needs) = code(refused);
    (code.wrapping_add(16), needs)
}
