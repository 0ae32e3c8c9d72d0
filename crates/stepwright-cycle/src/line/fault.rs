//! Why a row is refused: the word `pin` or `cycle`, and numbers.

use core::fmt;

use stepwright_protocol::{Numbers, OwnFault, Text, flash_text};

use crate::strategy::Refusal;

/// Why a board refuses a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CycleFault {
    /// `pin NUMBER`: the pin in the number of this index is not on the board, or is used by another
    /// motor.
    Pin {
        /// The index of the number in the line, from 1.
        number: u8,
    },
    /// `cycle CODE,MOTOR,NEEDS`: the cycle refuses.
    Refused(Refusal),
}

impl OwnFault for CycleFault {
    fn word(&self) -> Text {
        match self {
            CycleFault::Pin { .. } => flash_text!("pin"),
            CycleFault::Refused(_) => flash_text!("cycle"),
        }
    }

    fn number(&self, n: u8) -> Option<i64> {
        let refusal = match self {
            CycleFault::Pin { number } => return (n == 0).then_some((*number).into()),
            CycleFault::Refused(refusal) => *refusal,
        };
        let (code, needs) = code(refusal);
        match n {
            0 => Some(code.into()),
            1 => Some(refusal.motor().unwrap_or(0).into()),
            2 => Some(needs.into()),
            _ => None,
        }
    }

    fn read(word: &[u8], numbers: &mut Numbers<'_>) -> Option<CycleFault> {
        let first = numbers.up_to(u8::MAX)?;
        match word {
            b"pin" => Some(CycleFault::Pin { number: first }),
            b"cycle" => {
                let (motor, needs) = (numbers.up_to(u8::MAX)?, numbers.word()?);
                refusal(first, motor, needs).map(CycleFault::Refused)
            }
            _ => None,
        }
    }
}

impl fmt::Display for CycleFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CycleFault::Pin { number } => {
                write!(f, "the pin of number {number} is not its own, or another motor's")
            }
            CycleFault::Refused(refusal) => refusal.fmt(f),
        }
    }
}

/// The code of a refusal, and the delay that would be accepted.
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

/// The refusal with this code.
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

/// The code of a refusal in the homing field of a report.
pub(crate) fn home_code(refused: Refusal) -> (u8, u32) {
    let (code, needs) = code(refused);
    (code.wrapping_add(16), needs)
}
