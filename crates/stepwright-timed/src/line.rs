//! The timed driver over a serial line, both sides: a line, its answer.
//!
//! ```text
//!   host   W1,66,48,0,0,1,0,0,16,48,32␍          board   Y␍
//!          M1,240,15000,8900,64,1000,19,0␍               0␍
//!          V1␍                                           1250,240,15064,64,…␍
//! ```
//!
//! A line is a letter and decimal numbers with commas between them, and ends with a carriage
//! return. A program on a chip that has the driver reads [`Line`] and answers; the command
//! `stepwright timed --port` writes them and reads [`Report`].
//!
//! | line | numbers | answer |
//! | --- | --- | --- |
//! | `?` | | `stepwright-timed uno hz=16000000 timers=1` |
//! | `W` | timer, port as its letter's ASCII code, mask, levels without current, whether these follow the last step, whether the motor is on a motor shield, phase, levels of each phase (2, 4, 8 or 16) | `Y`, or `E` while it moves or if the pins can't be had |
//! | `L` | timer, 0 or 1: a new top waits in the compare register | `Y` |
//! | `U` | timer, milliseconds from check to check by the main program; 0: none | `Y` |
//! | `M` | timer, control byte, top, limit, modification, milliseconds from update to update, updates, the caller's milliseconds at the call | the [result code](super::Code); −4 before any `W`, but for a stop |
//! | `V` | timer | the numbers of [`Report`] |
//!
//! All else is answered `E`. A line may have a checksum, `*` and the two digits of its CRC-8 (that
//! of the serial protocol), which its answer has then too; one with the checksum of another line
//! is answered `E sum`.

use core::fmt;

use stepwright::drive::Sequence;

use super::dump::Dump;
use super::order::{Control, SetSpeed, Status};

/// The most numbers of a line.
const MOST: usize = 7 + 16;
/// The longest line that is read, in bytes.
pub const LONGEST: usize = 123;
/// How the answer to `?` begins.
pub const NAME: &str = "stepwright-timed";

/// A line of the host, read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// `?`: the board's name, clock and timers.
    Info,
    /// `W`: the wiring of a timer's motor.
    Wire(u8, Wire),
    /// `L`: whether a new top waits in the compare register.
    Latched(u8, bool),
    /// `U`: milliseconds from check to check; 0: none.
    Check(u8, u16),
    /// `M`: an order, and the caller's milliseconds at the call.
    Move(u8, SetSpeed, u32),
    /// `V`: how is it?
    Look(u8),
}

/// What a motor's driver is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wire {
    /// The port's letter.
    pub port: u8,
    /// Its pins.
    pub mask: u8,
    /// What they get.
    pub sequence: Sequence,
    /// Whether the motor shield's enables are on while it moves.
    pub shield: bool,
    /// Where the motor is in its sequence.
    pub phase: u8,
}

/// What `V` is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// Milliseconds since the call.
    pub ms: u32,
    /// The driver's numbers.
    pub dump: Dump,
    /// Whether the motor moves.
    pub moving: bool,
    /// Milliseconds from the call to the callback that the end was reached.
    pub reached: Option<u32>,
    /// Likewise of a fault.
    pub fault: Option<u32>,
}

impl Report {
    /// How many numbers there are.
    pub const NUMBERS: usize = 14;

    /// Its numbers, in the order of the line: milliseconds, the dump's ten in the article's
    /// order, whether it moves, and both callbacks, 1 more than their milliseconds or 0.
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

    /// Reads an answer; `None` if it is none.
    pub fn read(text: &[u8]) -> Option<Report> {
        let numbers = Numbers::read(text)?;
        let n = |at: usize| numbers.all.get(at).copied().unwrap_or(0);
        let small = |at: usize| u16::try_from(n(at)).ok();
        let byte = |at: usize| u8::try_from(n(at)).ok();
        if usize::from(numbers.count) != Report::NUMBERS {
            return None;
        }
        Some(Report {
            ms: n(0),
            dump: Dump {
                control: Control::from_bits(byte(1)?),
                top: n(2),
                modification: n(3),
                steps_left: n(4),
                time: n(5),
                status: Status::from_bits(byte(6)?),
                update_ms: small(7)?,
                end: n(8),
                counts: small(9)?,
                pattern: byte(10)?,
            },
            moving: n(11) != 0,
            reached: n(12).checked_sub(1),
            fault: n(13).checked_sub(1),
        })
    }
}

/// Decimal numbers with commas between them.
struct Numbers {
    all: [u32; MOST],
    count: u8,
}

impl Numbers {
    #[inline(never)]
    fn read(text: &[u8]) -> Option<Numbers> {
        let mut numbers = Numbers { all: [0; MOST], count: 0 };
        for digits in text.split(|byte| *byte == b',') {
            let place = numbers.all.get_mut(usize::from(numbers.count))?;
            if digits.is_empty() {
                return None;
            }
            for byte in digits {
                let digit = byte.wrapping_sub(b'0');
                if digit > 9 {
                    return None;
                }
                *place = place.checked_mul(10)?.checked_add(digit.into())?;
            }
            numbers.count = numbers.count.wrapping_add(1);
        }
        Some(numbers)
    }
}

impl Line {
    /// The number of the timer whose motor it is about; 0 for all.
    pub const fn timer(&self) -> u8 {
        match self {
            Line::Info => 0,
            Line::Wire(timer, _)
            | Line::Latched(timer, _)
            | Line::Check(timer, _)
            | Line::Move(timer, ..)
            | Line::Look(timer) => *timer,
        }
    }

    /// Reads a line without its carriage return; `None` if it is none.
    pub fn read(line: &[u8]) -> Option<Line> {
        let (letter, text) = line.split_first()?;
        if *letter == b'?' {
            return text.is_empty().then_some(Line::Info);
        }
        let numbers = Numbers::read(text)?;
        let n = |at: usize| numbers.all.get(at).copied().unwrap_or(0);
        let byte = |at: usize| u8::try_from(n(at)).ok();
        let small = |at: usize| u16::try_from(n(at)).ok();
        let timer = byte(0)?;
        let line = match (letter, numbers.count) {
            (b'W', count) => return wire(timer, &numbers.all, count),
            (b'L', 2) => Line::Latched(timer, n(1) != 0),
            (b'U', 2) => Line::Check(timer, small(1)?),
            (b'M', 8) => {
                let order = SetSpeed {
                    control: Control::from_bits(byte(1)?),
                    top: n(2),
                    limit: n(3),
                    modification: n(4),
                    update_ms: small(5)?,
                    mod_counts: small(6)?,
                };
                Line::Move(timer, order, n(7))
            }
            (b'V', 1) => Line::Look(timer),
            _ => return None,
        };
        Some(line)
    }
}

fn wire(timer: u8, numbers: &[u32; MOST], count: u8) -> Option<Line> {
    let mut bytes = [0u8; MOST];
    for (byte, number) in bytes.iter_mut().zip(numbers) {
        *byte = u8::try_from(*number).ok()?;
    }
    let [_, port, mask, off, rests, shield, phase, ..] = bytes;
    let rows = bytes.get(7..usize::from(count))?;
    if off & !mask != 0 {
        return None;
    }
    let sequence = Sequence::new(rows, mask).ok()?.with_rest(off, rests != 0);
    (phase < sequence.len())
        .then_some(Line::Wire(timer, Wire { port, mask, sequence, shield: shield != 0, phase }))
}

/// As it is sent, without its carriage return.
impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Line::Info => f.write_str("?"),
            Line::Wire(timer, Wire { port, mask, sequence, shield, phase }) => {
                let (off, rests) = (sequence.off(), u8::from(sequence.rests()));
                let shield = u8::from(*shield);
                write!(f, "W{timer},{port},{mask},{off},{rests},{shield},{phase}")?;
                (0..sequence.len()).try_for_each(|row| write!(f, ",{}", sequence.levels(row)))
            }
            Line::Latched(timer, on) => write!(f, "L{timer},{}", u8::from(*on)),
            Line::Check(timer, ms) => write!(f, "U{timer},{ms}"),
            Line::Move(timer, order, ms) => {
                let SetSpeed { control, top, limit, modification, update_ms, mod_counts } = order;
                let control = control.bits();
                write!(
                    f,
                    "M{timer},{control},{top},{limit},{modification},{update_ms},{mod_counts},{ms}"
                )
            }
            Line::Look(timer) => write!(f, "V{timer}"),
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;
    use stepwright::drive::sequence::{L6219_QUARTER, SHIELD, UNIPOLAR_HALF};

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
            Line::Info,
            Line::Wire(5, wire(UNIPOLAR_HALF.on_bits(&[5, 2, 1, 0]), 0b10_0111, false)),
            Line::Wire(1, wire(L6219_QUARTER.on_bits(&[2, 3, 4, 5, 6, 7]), 0b1111_1100, false)),
            Line::Wire(3, wire(SHIELD.on_bits(&[6, 7]), 0b1100_0000, true)),
            Line::Latched(1, true),
            Line::Check(4, 50),
            Line::Move(1, order, 1_009),
            Line::Look(3),
        ] {
            let text = line.to_string();
            assert!(text.len() <= LONGEST, "{text}");
            let read = Line::read(text.as_bytes()).map(|line| line.to_string());
            assert_eq!(read.as_ref(), Some(&text));
        }
    }

    #[test]
    fn what_is_no_line_is_not_read() {
        for bad in [
            "",
            "?1",
            "V",
            "V1,",
            "V1,2",
            "V-1",
            "V4294967296",
            "x1",
            "M1,240,1,2,3,4,5",
            "M1,256,1,2,3,4,5,0",
            "M1,240,1,2,3,65536,5,0",
            "W1,66,48,0,0,1,0,0,16,48",
            "W1,66,48,0,0,1,0,0,16,48,64",
            "W1,66,48,1,0,1,0,0,16,48,32",
            "L1",
            "U1,65536",
            "W1,66,48,0,0,1,4,0,16,48,32",
        ] {
            assert_eq!(Line::read(bad.as_bytes()), None, "{bad}");
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
