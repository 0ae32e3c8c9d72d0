//! The rows of the timed driver on a board's line, for both sides: lines and answers.
//!
//! ```text
//!   host   :W1,66,48,0,0,1,0,0,16,48,32␍         board   Y␍
//!          :M1,240,15000,8900,64,1000,19,0␍              0␍
//!          :?1␍                                          1250,240,15064,64,…␍
//! ```
//!
//! Frame, checksum and the rows `?`, `F`, `Z`, `K` are common to all programs
//! ([`stepwright_protocol`]); these rows are specific to the timed driver. It counts no position,
//! so a board has no axis for `V` and `I`; `Z` and `K` stop all motors like a top of 0. A program
//! on a chip with the driver reads [`Line`] and answers; the command `stepwright timed --port`
//! writes them and reads [`Report`].
//!
//! | line | numbers | answer |
//! | --- | --- | --- |
//! | `:W` | timer, port as its letter's ASCII code, mask, levels without current, whether these follow the last step, whether the motor is on a motor shield, phase, levels of each phase (2, 4, 8 or 16) | `Y`; not while the motor moves |
//! | `:L` | timer, 0 or 1: a new top waits in the compare register | `Y`; not while the motor moves |
//! | `:U` | timer, milliseconds from one check by the main program to the next; 0: none | `Y` |
//! | `:M` | timer, control byte, top, limit, modification, milliseconds from one update to the next, updates, the caller's milliseconds at the call | the [result code](super::Code); −4 before any `:W`, except for a stop |
//! | `:?` | timer | the numbers of [`Report`] |
//!
//! A row that can't be carried out is answered by `E` and a reason ([`Unwired`]). In the answer to
//! `?`, `timers=` lists the timers.

use core::fmt;

use stepwright::drive::Sequence;
use stepwright_protocol::{Numbers, OwnFault, Text, flash_text};

use super::dump::Dump;
use super::order::{Control, SetSpeed, Status};

/// The most rows of a motor's table.
const ROWS: usize = 16;
/// The longest line that is accepted, in bytes.
pub const LONGEST: usize = 124;
/// The beginning of the answer to `?`.
pub const NAME: &str = "stepwright-timed";

/// A parsed row of the timed driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// `:W`: the wiring of a timer's motor.
    Wire(u8, Wire),
    /// `:L`: whether a new top waits in the compare register.
    Latched(u8, bool),
    /// `:U`: milliseconds from one check to the next; 0: none.
    Check(u8, u16),
    /// `:M`: an order, and the caller's milliseconds at the call.
    Move(u8, SetSpeed, u32),
    /// `:?`: asks for a report.
    Look(u8),
}

/// Why a board refuses a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unwired {
    /// `timer`: the board has no motor on this timer.
    Timer,
    /// `pins`: the board does not have these pins, or the serial line uses them.
    Pins,
}

impl fmt::Display for Unwired {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Unwired::Timer => "it has no motor on this timer",
            Unwired::Pins => "it has not got these pins, or the serial line has them",
        })
    }
}

impl OwnFault for Unwired {
    fn word(&self) -> Text {
        match self {
            Unwired::Timer => flash_text!("timer"),
            Unwired::Pins => flash_text!("pins"),
        }
    }

    fn number(&self, _: u8) -> Option<i64> {
        None
    }

    fn read(word: &[u8], _: &mut Numbers<'_>) -> Option<Unwired> {
        match word {
            b"timer" => Some(Unwired::Timer),
            b"pins" => Some(Unwired::Pins),
            _ => None,
        }
    }
}

/// The wiring of a motor's driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wire {
    /// The port's letter.
    pub port: u8,
    /// The mask of its pins.
    pub mask: u8,
    /// The levels of the pins in each step.
    pub sequence: Sequence,
    /// Whether the motor shield's enables are on while it moves.
    pub shield: bool,
    /// The phase of the motor in its sequence.
    pub phase: u8,
}

/// The answer to `:?`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// Milliseconds since the call.
    pub ms: u32,
    /// The fields of the driver's dump.
    pub dump: Dump,
    /// Whether the motor moves.
    pub moving: bool,
    /// Milliseconds from the call to the callback that the end was reached.
    pub reached: Option<u32>,
    /// Milliseconds from the call to the callback for a fault.
    pub fault: Option<u32>,
}

impl Report {
    /// The number of numbers in a report.
    pub const NUMBERS: usize = 14;

    /// The numbers in the order of the line: milliseconds, the ten fields of the dump in the
    /// article's order, whether the motor moves, and both callbacks, each as its milliseconds plus
    /// 1, or 0.
    pub fn numbers(&self) -> [u32; Report::NUMBERS] {
        let Dump { control, top, modification, steps_left, time, status, update_ms, end, .. } =
            self.dump;
        let after = |ms: Option<u32>| ms.map_or(0, |ms| ms.saturating_add(1));
        [
            self.ms,
            control.bits().into(),
            top,
            modification,
            steps_left,
            time,
            status.bits().into(),
            update_ms.into(),
            end,
            self.dump.counts.into(),
            self.dump.pattern.into(),
            self.moving.into(),
            after(self.reached),
            after(self.fault),
        ]
    }

    /// Parses an answer; `None` if it is no report.
    pub fn read(text: &[u8]) -> Option<Report> {
        let n = &mut Numbers::of(text);
        let report = Report {
            ms: n.word()?,
            dump: Dump {
                control: Control::from_bits(n.up_to(u8::MAX)?),
                top: n.word()?,
                modification: n.word()?,
                steps_left: n.word()?,
                time: n.word()?,
                status: Status::from_bits(n.up_to(u8::MAX)?),
                update_ms: short(n)?,
                end: n.word()?,
                counts: short(n)?,
                pattern: n.up_to(u8::MAX)?,
            },
            moving: n.word()? != 0,
            reached: n.word()?.checked_sub(1),
            fault: n.word()?.checked_sub(1),
        };
        n.is_end().then_some(report)
    }
}

/// The next number, of 16 bits.
fn short(n: &mut Numbers<'_>) -> Option<u16> {
    n.between(0, u16::MAX.into()).map(|number| number as u16)
}

impl Line {
    /// The number of the timer whose motor the row is for.
    pub const fn timer(&self) -> u8 {
        match self {
            Line::Wire(timer, _)
            | Line::Latched(timer, _)
            | Line::Check(timer, _)
            | Line::Move(timer, ..)
            | Line::Look(timer) => *timer,
        }
    }

    /// Parses the row with this letter and these numbers; `None` if there is no such row.
    #[inline(never)]
    pub fn read(letter: u8, n: &mut Numbers<'_>) -> Option<Line> {
        let timer = n.up_to(u8::MAX)?;
        Some(match letter {
            b'W' => Line::Wire(timer, wire(n)?),
            b'L' => Line::Latched(timer, n.flag()?),
            b'U' => Line::Check(timer, short(n)?),
            b'M' => {
                let order = SetSpeed {
                    control: Control::from_bits(n.up_to(u8::MAX)?),
                    top: n.word()?,
                    limit: n.word()?,
                    modification: n.word()?,
                    update_ms: short(n)?,
                    mod_counts: short(n)?,
                };
                Line::Move(timer, order, n.word()?)
            }
            b'?' => Line::Look(timer),
            _ => return None,
        })
    }
}

#[inline(never)]
fn wire(n: &mut Numbers<'_>) -> Option<Wire> {
    let (port, mask) = (n.up_to(u8::MAX)?, n.up_to(u8::MAX)?);
    let (off, rests, shield) = (n.up_to(mask)?, n.flag()?, n.flag()?);
    let phase = n.up_to(ROWS as u8 - 1)?;
    let (mut rows, mut count) = ([0u8; ROWS], 0usize);
    while !n.is_end() {
        *rows.get_mut(count)? = n.up_to(u8::MAX)?;
        count = count.wrapping_add(1);
    }
    let sequence = Sequence::new(rows.get(..count)?, mask).ok()?.with_rest(off, rests);
    if off & !mask != 0 || phase >= sequence.len() {
        return None;
    }
    Some(Wire { port, mask, sequence, shield, phase })
}

/// The row as it is sent, without its carriage return.
impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Line::Wire(timer, Wire { port, mask, sequence, shield, phase }) => {
                let (off, rests) = (sequence.off(), u8::from(sequence.rests()));
                let shield = u8::from(*shield);
                write!(f, ":W{timer},{port},{mask},{off},{rests},{shield},{phase}")?;
                (0..sequence.len()).try_for_each(|row| write!(f, ",{}", sequence.levels(row)))
            }
            Line::Latched(timer, on) => write!(f, ":L{timer},{}", u8::from(*on)),
            Line::Check(timer, ms) => write!(f, ":U{timer},{ms}"),
            Line::Move(timer, order, ms) => {
                let SetSpeed { control, top, limit, modification, update_ms, mod_counts } = order;
                let control = control.bits();
                write!(
                    f,
                    ":M{timer},{control},{top},{limit},{modification},{update_ms},{mod_counts},{ms}"
                )
            }
            Line::Look(timer) => write!(f, ":?{timer}"),
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;
    use stepwright::drive::sequence::{L6219_QUARTER, SHIELD, UNIPOLAR_HALF};
    use stepwright_protocol::{Fault, read_row};

    /// Parses a row with its mark.
    fn read(text: &str) -> Result<Line, Fault<Unwired>> {
        read_row(text.strip_prefix(':').unwrap().as_bytes(), Line::read)
    }

    #[test]
    fn what_is_written_is_read() {
        let wire = |sequence: Sequence, mask, shield| Wire {
            port: b'H',
            mask,
            sequence,
            shield,
            phase: sequence.len() - 1,
        };
        let order = SetSpeed {
            control: Control::DRV_EN | Control::IRQ_TIMING,
            top: u32::MAX,
            limit: 1,
            modification: 2,
            update_ms: u16::MAX,
            mod_counts: 4,
        };
        for line in [
            Line::Wire(5, wire(UNIPOLAR_HALF.on_bits(&[5, 2, 1, 0]), 0b10_0111, false)),
            Line::Wire(1, wire(L6219_QUARTER.on_bits(&[2, 3, 4, 5, 6, 7]), 0b1111_1100, false)),
            Line::Wire(3, wire(SHIELD.on_bits(&[6, 7]), 0b1100_0000, true)),
            Line::Latched(1, true),
            Line::Check(4, 50),
            Line::Move(1, order, 1_009),
            Line::Look(3),
        ] {
            let text = line.to_string();
            assert!(text.len() + 3 <= LONGEST, "{text}");
            assert_eq!(read(&text).map(|line| line.to_string()), Ok(text));
        }
    }

    #[test]
    fn what_is_no_line_is_not_read() {
        for bad in [
            ":",
            ":?",
            ":?1,",
            ":?1,2",
            ":x1",
            ":M1,240,1,2,3,4,5",
            ":W1,66,48,0,0,1,0,0,16,48",
            ":W1,66,48,0,0,1,0,0,16,48,64",
            ":W1,66,48,1,0,1,0,0,16,48,32",
            ":L1",
            ":W1,66,48,0,0,1,4,0,16,48,32",
            ":W1,66,3,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
        ] {
            assert_eq!(read(bad), Err(Fault::Line), "{bad}");
        }
        for (bad, number, most) in [
            (":?-1", 1, u8::MAX.into()),
            (":?256", 1, u8::MAX.into()),
            (":M1,256,1,2,3,4,5,0", 2, u8::MAX.into()),
            (":M1,240,1,2,3,65536,5,0", 6, u16::MAX.into()),
            (":M1,240,4294967296,2,3,4,5,0", 3, u32::MAX.into()),
            (":U1,65536", 2, u16::MAX.into()),
            (":L1,2", 2, 1),
            (":W1,66,48,49,0,1,0,0,16,48,32", 4, 48),
        ] {
            assert_eq!(read(bad), Err(Fault::Range { number, least: 0, most }), "{bad}");
        }
        for (text, reason) in [("E timer", Unwired::Timer), ("E pins", Unwired::Pins)] {
            assert_eq!(Fault::read(text.as_bytes()), Some(Fault::Own(reason)));
        }
    }

    #[test]
    fn a_report_comes_back() {
        let dump = Dump {
            control: Control::DRV_EN,
            top: 15_064,
            modification: 128,
            steps_left: 8_722,
            time: 2_009,
            status: Status::REACHED,
            update_ms: 1_000,
            end: u32::MAX,
            counts: 18,
            pattern: 3,
        };
        for (reached, fault) in [(None, Some(0)), (Some(7), None)] {
            let report = Report { ms: 1_250, dump, moving: true, reached, fault };
            let text: std::vec::Vec<_> = report.numbers().iter().map(ToString::to_string).collect();
            assert_eq!(Report::read(text.join(",").as_bytes()), Some(report));
        }
        assert_eq!(Report::read(b"1,2,3"), None);
        assert_eq!(Report::read(b"E"), None);
    }
}
