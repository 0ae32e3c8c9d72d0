//! The rows of the laws on a board's line, for both sides: lines and answers.
//!
//! ```text
//!   host   :A128849018880000,128849018880000,…␍   board   Y␍      the law and its constants
//!          :C100,500000␍                                  Y␍      after 100 steps 500 steps/s²
//!          :G1000␍                                        Y␍      1,000 steps forward
//!          V1␍                                            317␍
//! ```
//!
//! Frame, checksum and the rows `?`, `F`, `V1`, `Z`, `K`, `I1` are common to all programs
//! ([`stepwright_protocol`]); these rows are specific to the laws. Delays are in 2⁻³² ticks of 1
//! MHz, except for `:F`; accelerations in 0.001 steps/s². The host computes the constants of a law
//! ([`Recipe`]); the board computes the delays from them.
//!
//! | line | numbers |
//! | --- | --- |
//! | `:A` | general form: c₀ as emitted and as the formula continues from it, c_min, acceleration, deceleration, 4 or 2 for 4n + 1 or 2n |
//! | `:F` | published listing: c₀, c_min in ticks |
//! | `:L` | linear factor: c₀ twice, c_min, n₁, n₂, j₁, j₂ |
//! | `:P` | power term: c₀, c_min; up and down: where the formula begins, 1/n_t in 2⁻⁶³; p |
//! | `:S` | in stages, piecewise: c₀, c_min; where the formula begins up and down; breaks |
//! | `:C` | the general form's acceleration: after how many steps (0: from now on), and its value |
//! | `:G` | the number of steps, negative for backward |
//! | `:R` | 0 or 1: runs backward or forward until it is stopped |
//!
//! Each is answered by `Y`, or by `E` and a reason ([`Refused`]). In the answer to `?`, `can=`
//! lists the laws that the board has.

#![cfg_attr(
    not(all(feature = "constant", feature = "transitions", feature = "power")),
    allow(unused_imports, unused_variables, reason = "what the other laws need")
)]

use core::fmt;

use super::choice::{LawName, Recipe};
use super::general::{Divisor, RampConstants};
use super::linear::{Corners, FactorConstants};
use super::piecewise::StageConstants;
use super::power::PowerConstants;
use stepwright::units::{Accel, Ticks};
use stepwright_protocol::{Numbers, OwnFault, Text, flash_text};

/// The longest line that is accepted, in bytes.
pub const LONGEST: usize = 140;
/// The beginning of the answer to `?`.
pub const NAME: &str = "stepwright-laws";
/// The number of pulses of a run without an end.
pub const ENDLESS: u32 = 1 << 31;

/// A parsed row of the laws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// `:A`, `:F`, `:L`, `:P`, `:S`: the law of the following travels.
    Law(Recipe),
    /// `:C`: another acceleration after this many steps; 0: from now on.
    Change(u32, Accel),
    /// `:G`: makes this many steps.
    Go(i32),
    /// `:R`: runs until it is stopped; true is forward.
    Run(bool),
}

/// Why a board refuses a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// `rest`: allowed only while the motor moves, with a law whose way up is not over.
    Rest,
    /// `law`: no law was set, or this law can't be changed during a travel.
    Law,
    /// `unsound`: the constants fit no travel ([`Recipe::is_sound`]).
    Unsound,
    /// `full`: the board stores no more changes of a travel.
    Full,
    /// `fast N`: with this law the shortest delay of the board is N ticks.
    Fast(Ticks),
}

impl OwnFault for Refused {
    fn word(&self) -> Text {
        match self {
            Refused::Rest => flash_text!("rest"),
            Refused::Law => flash_text!("law"),
            Refused::Unsound => flash_text!("unsound"),
            Refused::Full => flash_text!("full"),
            Refused::Fast(_) => flash_text!("fast"),
        }
    }

    fn number(&self, n: u8) -> Option<i64> {
        match self {
            Refused::Fast(ticks) if n == 0 => Some((*ticks).into()),
            _ => None,
        }
    }

    fn read(word: &[u8], numbers: &mut Numbers<'_>) -> Option<Refused> {
        Some(match word {
            b"rest" => Refused::Rest,
            b"law" => Refused::Law,
            b"unsound" => Refused::Unsound,
            b"full" => Refused::Full,
            b"fast" => Refused::Fast(numbers.word()?),
            _ => return None,
        })
    }
}

impl Line {
    /// Parses the row with this letter and these numbers; `None` if there is no such row.
    #[inline(never)]
    pub fn read(letter: u8, n: &mut Numbers<'_>) -> Option<Line> {
        Some(match letter {
            b'G' => Line::Go(n.count()?),
            b'R' => Line::Run(n.flag()?),
            b'C' => Line::Change(n.word()?, accel(n)?),
            #[cfg(feature = "constant")]
            b'A' => {
                let (lead, count, shortest) = (n.wide()?, n.wide()?, n.wide()?);
                let (accel, decel) = (accel(n)?, accel(n)?);
                let divisor = match n.between(2, 4)? {
                    4 => Divisor::FourN,
                    2 => Divisor::TwoN,
                    _ => return None,
                };
                let all = RampConstants { lead, count, shortest, accel, decel, divisor };
                Line::Law(Recipe::Austin(all))
            }
            #[cfg(feature = "constant")]
            b'F' => Line::Law(Recipe::AustinFixed(n.word()?, n.word()?)),
            #[cfg(feature = "transitions")]
            b'L' => {
                let (lead, count, shortest) = (n.wide()?, n.wide()?, n.wide()?);
                let corners =
                    Corners { n1: n.word()?, n2: n.word()?, j1: n.word()?, j2: n.word()? };
                Line::Law(Recipe::LinearFactor(FactorConstants { lead, count, shortest, corners }))
            }
            #[cfg(feature = "power")]
            b'P' => {
                let (lead, shortest) = (n.wide()?, n.wide()?);
                let (rise, fall) = ((n.wide()?, n.wide()?), (n.wide()?, n.wide()?));
                let power = n.up_to(u8::MAX)?;
                Line::Law(Recipe::Power(PowerConstants { lead, shortest, rise, fall, power }))
            }
            #[cfg(feature = "transitions")]
            b'S' => {
                let (lead, shortest) = (n.wide()?, n.wide()?);
                let (rise, fall, breaks) = (n.wide()?, n.wide()?, n.up_to(u8::MAX)?);
                Line::Law(Recipe::Piecewise(StageConstants { lead, shortest, rise, fall, breaks }))
            }
            _ => return None,
        })
    }
}

/// An acceleration in 0.001 steps/s².
fn accel(n: &mut Numbers<'_>) -> Option<Accel> {
    match Accel::from_millisteps(n.wide()?) {
        Ok(accel) => Some(accel),
        Err(_) => n.range(Accel::MIN.millisteps() as i64, Accel::MAX.millisteps() as i64),
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refused::Rest => f.write_str("the motor does not move, or its way up is over"),
            Refused::Law => f.write_str("no law was named, or it does not change on its way"),
            Refused::Unsound => f.write_str("no travel has these numbers"),
            Refused::Full => f.write_str("it keeps no more changes of a travel"),
            Refused::Fast(ticks) => write!(f, "its delays by this law are {ticks} µs and more"),
        }
    }
}

/// The row as it is sent, without its carriage return.
impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            #[cfg(feature = "constant")]
            Line::Law(Recipe::Austin(c)) => {
                let RampConstants { lead, count, shortest, accel, decel, divisor } = c;
                let (accel, decel) = (accel.millisteps(), decel.millisteps());
                let divisor = if *divisor == Divisor::TwoN { 2 } else { 4 };
                write!(f, ":A{lead},{count},{shortest},{accel},{decel},{divisor}")
            }
            #[cfg(feature = "constant")]
            Line::Law(Recipe::AustinFixed(c0, c_min)) => write!(f, ":F{c0},{c_min}"),
            #[cfg(feature = "transitions")]
            Line::Law(Recipe::LinearFactor(c)) => {
                let FactorConstants { lead, count, shortest, corners } = c;
                let Corners { n1, n2, j1, j2 } = corners;
                write!(f, ":L{lead},{count},{shortest},{n1},{n2},{j1},{j2}")
            }
            #[cfg(feature = "power")]
            Line::Law(Recipe::Power(c)) => {
                let PowerConstants { lead, shortest, rise, fall, power } = c;
                write!(f, ":P{lead},{shortest},{},{},{},{},{power}", rise.0, rise.1, fall.0, fall.1)
            }
            #[cfg(feature = "transitions")]
            Line::Law(Recipe::Piecewise(c)) => {
                let StageConstants { lead, shortest, rise, fall, breaks } = c;
                write!(f, ":S{lead},{shortest},{rise},{fall},{breaks}")
            }
            Line::Change(steps, accel) => write!(f, ":C{steps},{}", accel.millisteps()),
            Line::Go(steps) => write!(f, ":G{steps}"),
            Line::Run(forward) => write!(f, ":R{}", u8::from(*forward)),
        }
    }
}

/// Parses the laws in the answer to `?`: the names after `can=`.
pub fn can(laws: &str) -> impl Iterator<Item = LawName> + '_ {
    let known = |name: &str| LawName::ALL.into_iter().find(|law| law.name() == name);
    laws.split(',').filter_map(known)
}
