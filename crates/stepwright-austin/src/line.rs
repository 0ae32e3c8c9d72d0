//! The laws over a serial line, both sides: a line, its answer.
//!
//! ```text
//!   host   A128849018880000,128849018880000,…␍    board   Y␍      the law and its constants
//!          C100,500000␍                                   Y␍      after 100 steps 500 steps/s²
//!          G1000␍                                         Y␍      1,000 steps forward
//!          V␍                                             1,1,317,0,2500␍
//! ```
//!
//! A line is a letter and decimal numbers with commas between them, and ends with a carriage
//! return. Delays are in 2⁻³² ticks of 1 MHz, but for `F`, accelerations in 0.001 steps/s².
//! The host works the constants of a law out ([`Recipe`]), the board makes the delays of them.
//!
//! | line | numbers | answer |
//! | --- | --- | --- |
//! | `?` | | `stepwright-laws uno hz=16000000 can=austin,…` |
//! | `A` | general form: c₀ as emitted and as the formula goes on from it, c_min, acceleration, deceleration, 4 or 2 for 4n + 1 or 2n | `Y` |
//! | `F` | published listing: c₀, c_min in ticks | `Y` |
//! | `L` | linear factor: c₀ twice, c_min, n₁, n₂, j₁, j₂ | `Y` |
//! | `P` | power term: c₀, c_min; up and down: where the formula begins, 1/n_t in 2⁻⁶³; p | `Y` |
//! | `S` | in stages, piecewise: c₀, c_min; where the formula begins up and down; breaks | `Y` |
//! | `C` | the general form's acceleration: after this many steps (0: from now on), which | `Y` |
//! | `G` | how many steps, a minus for backward | `Y` |
//! | `R` | 0 or 1: backward or forward until it is stopped | `Y` |
//! | `Z` | stop along the ramp; the position is kept | `Y` |
//! | `K` | no step more; the position is lost, if it moved | `Y` |
//! | `I` | the present position is 0 | `Y` |
//! | `V` | | the numbers of [`Progress`] |
//!
//! What can't be is answered `E` and a word, see [`Refused`]. A line may have a checksum, `*` and
//! the two digits of its [CRC-8](stepwright_protocol::crc), which its answer has then too.

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

/// The longest line that is read, in bytes.
pub const LONGEST: usize = 139;
/// How the answer to `?` begins.
pub const NAME: &str = "stepwright-laws";
/// The most numbers of a line.
const MOST: usize = 7;
/// Pulses of a run until it is stopped.
pub const ENDLESS: u32 = 1 << 31;

/// A line of the host, read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// `?`: what the board is.
    Info,
    /// `A`, `F`, `L`, `P`, `S`: the law of the travels to come.
    Law(Recipe),
    /// `C`: another acceleration after this many steps; 0: from now on.
    Change(u32, Accel),
    /// `G`: this many steps.
    Go(i32),
    /// `R`: until it is stopped; true is forward.
    Run(bool),
    /// `Z`: stop along the ramp.
    Stop,
    /// `K`: no step more.
    Kill,
    /// `I`: the position is 0.
    Zero,
    /// `V`: how is it?
    Look,
}

/// Why a board doesn't do what a line says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// `E line`: it is none, or came damaged.
    Line,
    /// `E sum`: its checksum is that of another line.
    Sum,
    /// `E moving`: that is for a motor at rest.
    Moving,
    /// `E rest`: that is for a motor that moves, by a law whose way up is not over.
    Rest,
    /// `E law`: no law was named, or this one changes nothing on its way.
    Law,
    /// `E range`: numbers that no travel has ([`Recipe::is_sound`]), or too many changes.
    Range,
    /// `E fast N`: the board makes this law's delays of N ticks and more.
    Fast(Ticks),
}

impl Refused {
    /// The word, and a number behind it.
    pub const fn parts(self) -> (&'static str, Option<Ticks>) {
        match self {
            Refused::Line => ("line", None),
            Refused::Sum => ("sum", None),
            Refused::Moving => ("moving", None),
            Refused::Rest => ("rest", None),
            Refused::Law => ("law", None),
            Refused::Range => ("range", None),
            Refused::Fast(ticks) => ("fast", Some(ticks)),
        }
    }

    /// Reads an answer; `None` if it is no refusal.
    pub fn read(answer: &str) -> Option<Refused> {
        let mut words = answer.split(' ');
        if words.next() != Some("E") {
            return None;
        }
        let refused = match words.next() {
            Some("sum") => Refused::Sum,
            Some("moving") => Refused::Moving,
            Some("rest") => Refused::Rest,
            Some("law") => Refused::Law,
            Some("range") => Refused::Range,
            Some("fast") => Refused::Fast(words.next()?.parse().ok()?),
            _ => Refused::Line,
        };
        Some(refused)
    }
}

/// What `V` is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Whether the motor moves.
    pub moving: bool,
    /// Steps since the power came or the position was 0; `None` once a kill has lost it.
    pub position: Option<i32>,
    /// Steps that came late.
    pub late: u32,
    /// The delay made last, in ticks; 0 before a travel's first.
    pub delay: Ticks,
}

impl Progress {
    /// Reads an answer: whether it moves, whether the position is known, the position, late
    /// steps, the last delay. `None` if it is none.
    pub fn read(answer: &str) -> Option<Progress> {
        let mut numbers = answer.split(',');
        let mut next = || numbers.next()?.parse::<i64>().ok();
        let (moving, known) = (next()? != 0, next()? != 0);
        let position = i32::try_from(next()?).ok()?;
        let (late, delay) = (u32::try_from(next()?).ok()?, u32::try_from(next()?).ok()?);
        numbers.next().is_none().then_some(())?;
        Some(Progress { moving, position: known.then_some(position), late, delay })
    }
}

/// Decimal numbers with commas between them.
struct Numbers {
    all: [u64; MOST],
    count: u8,
}

impl Numbers {
    #[inline(never)]
    fn read(text: &[u8]) -> Option<Numbers> {
        let mut numbers = Numbers { all: [0; MOST], count: 0 };
        if text.is_empty() {
            return Some(numbers);
        }
        for digits in text.split(|byte| *byte == b',') {
            let place = numbers.all.get_mut(usize::from(numbers.count))?;
            *place = number(digits)?;
            numbers.count = numbers.count.wrapping_add(1);
        }
        Some(numbers)
    }
}

/// A decimal number.
fn number(digits: &[u8]) -> Option<u64> {
    let mut number = 0u64;
    for byte in digits {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        number = number.checked_mul(10)?.checked_add(digit.into())?;
    }
    (!digits.is_empty()).then_some(number)
}

/// A number with or without a sign.
fn signed(text: &[u8]) -> Option<i32> {
    let (minus, digits) = match text.split_first()? {
        (b'-', rest) => (true, rest),
        (b'+', rest) => (false, rest),
        _ => (false, text),
    };
    let number = i64::try_from(number(digits)?).ok()?;
    i32::try_from(if minus { number.wrapping_neg() } else { number }).ok()
}

impl Line {
    /// Reads a line without its carriage return; `None` if it is none.
    #[inline(never)]
    pub fn read(line: &[u8]) -> Option<Line> {
        let (letter, text) = line.split_first()?;
        if *letter == b'G' {
            return signed(text).map(Line::Go);
        }
        let Numbers { all, count } = Numbers::read(text)?;
        let [a, b, c, d, e, f, g] = all;
        let short = |n: u64| u32::try_from(n).ok();
        let accel = |n: u64| Accel::from_millisteps(n).ok();
        let line = match (letter, count) {
            (b'?', 0) => Line::Info,
            (b'Z', 0) => Line::Stop,
            (b'K', 0) => Line::Kill,
            (b'I', 0) => Line::Zero,
            (b'V', 0) => Line::Look,
            (b'R', 1) if a < 2 => Line::Run(a == 1),
            (b'C', 2) => Line::Change(short(a)?, accel(b)?),
            #[cfg(feature = "constant")]
            (b'A', 6) => {
                let divisor = match f {
                    4 => Divisor::FourN,
                    2 => Divisor::TwoN,
                    _ => return None,
                };
                let (accel, decel) = (accel(d)?, accel(e)?);
                let (lead, count, shortest) = (a, b, c);
                let all = RampConstants { lead, count, shortest, accel, decel, divisor };
                Line::Law(Recipe::Austin(all))
            }
            #[cfg(feature = "constant")]
            (b'F', 2) => Line::Law(Recipe::AustinFixed(short(a)?, short(b)?)),
            #[cfg(feature = "transitions")]
            (b'L', 7) => {
                let corners =
                    Corners { n1: short(d)?, n2: short(e)?, j1: short(f)?, j2: short(g)? };
                let (lead, count, shortest) = (a, b, c);
                let all = FactorConstants { lead, count, shortest, corners };
                Line::Law(Recipe::LinearFactor(all))
            }
            #[cfg(feature = "power")]
            (b'P', 7) => {
                let (lead, shortest, power) = (a, b, u8::try_from(g).ok()?);
                let all = PowerConstants { lead, shortest, rise: (c, d), fall: (e, f), power };
                Line::Law(Recipe::Power(all))
            }
            #[cfg(feature = "transitions")]
            (b'S', 5) => {
                let (lead, shortest, breaks) = (a, b, u8::try_from(e).ok()?);
                let all = StageConstants { lead, shortest, rise: c, fall: d, breaks };
                Line::Law(Recipe::Piecewise(all))
            }
            _ => return None,
        };
        Some(line)
    }
}

/// As it is sent, without its carriage return.
impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Line::Info => f.write_str("?"),
            #[cfg(feature = "constant")]
            Line::Law(Recipe::Austin(c)) => {
                let RampConstants { lead, count, shortest, accel, decel, divisor } = c;
                let (accel, decel) = (accel.millisteps(), decel.millisteps());
                let divisor = if *divisor == Divisor::TwoN { 2 } else { 4 };
                write!(f, "A{lead},{count},{shortest},{accel},{decel},{divisor}")
            }
            #[cfg(feature = "constant")]
            Line::Law(Recipe::AustinFixed(c0, c_min)) => write!(f, "F{c0},{c_min}"),
            #[cfg(feature = "transitions")]
            Line::Law(Recipe::LinearFactor(c)) => {
                let FactorConstants { lead, count, shortest, corners } = c;
                let Corners { n1, n2, j1, j2 } = corners;
                write!(f, "L{lead},{count},{shortest},{n1},{n2},{j1},{j2}")
            }
            #[cfg(feature = "power")]
            Line::Law(Recipe::Power(c)) => {
                let PowerConstants { lead, shortest, rise, fall, power } = c;
                write!(f, "P{lead},{shortest},{},{},{},{},{power}", rise.0, rise.1, fall.0, fall.1)
            }
            #[cfg(feature = "transitions")]
            Line::Law(Recipe::Piecewise(c)) => {
                let StageConstants { lead, shortest, rise, fall, breaks } = c;
                write!(f, "S{lead},{shortest},{rise},{fall},{breaks}")
            }
            Line::Change(steps, accel) => write!(f, "C{steps},{}", accel.millisteps()),
            Line::Go(steps) => write!(f, "G{steps}"),
            Line::Run(forward) => write!(f, "R{}", u8::from(*forward)),
            Line::Stop => f.write_str("Z"),
            Line::Kill => f.write_str("K"),
            Line::Zero => f.write_str("I"),
            Line::Look => f.write_str("V"),
        }
    }
}

/// What the answer to `?` says of the laws: `can=` and their names.
pub fn can(laws: &str) -> impl Iterator<Item = LawName> + '_ {
    let known = |name: &str| LawName::ALL.into_iter().find(|law| law.name() == name);
    laws.split(',').filter_map(known)
}
