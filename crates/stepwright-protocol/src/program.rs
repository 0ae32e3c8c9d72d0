//! The slave's half of the line for a program with fewer features: Austin's laws, the timed driver,
//! motor cycles.
//!
//! ```text
//!   bytes ─► Incoming ─► obey ─► F V I Z K ? : the same for every program
//!                          └───► :row       : the program's own, read, then carried out
//!   bytes ◄─ next_byte ◄─ Y, R, B, numbers, E and the reason
//! ```
//!
//! The grammar is that of the controller's [`Slave`](crate::Slave): one line, one answer, an
//! optional checksum. A program adds rows that begin with `:`, which begins no line of the
//! controller, so that no letter has two meanings. An answer is sent byte by byte and its numbers
//! are requested one by one, so that a board stores none of it.

mod fault;
mod incoming;
mod numbers;

pub use fault::{Fault, OwnFault};
pub use incoming::Incoming;
pub use numbers::Numbers;

use crate::flash::{Text, text};
use crate::line::CR;
use crate::sum::{self, Tail};
use crate::text::{Decimal, Piece};

/// The first byte of each row of a program. The letter and its numbers follow.
pub const ROW: u8 = b':';

/// A program on a board, controlled by its line.
///
/// An implementation MUST keep these promises:
/// - Only [`carry_out`](BoardProgram::carry_out) starts a motion.
/// - [`read`](BoardProgram::read) changes nothing: a line is obeyed only after all of its numbers
///   were read and none is left over.
/// - A position is `None` from the moment it may be wrong until it is set.
pub trait BoardProgram {
    /// A parsed row of the program.
    type Row;
    /// The program's own reasons to refuse a row.
    type Reason: OwnFault;

    /// Part `n` of the answer to `?`, counted from 0; `None` past the last. The answer is
    /// `stepwright-` and the program's name, the board's name, and words `name=value`. The words
    /// `axes`, `late` and `can` mean the same for every program, and `can` contains `sum`.
    fn about(&mut self, n: u8) -> Option<Piece>;

    /// The number of axes that have a position: 0 … 8.
    fn axes(&self) -> u8;

    /// Reads the row with this letter and these numbers. `None` if there is no such row, or if a
    /// number is outside its range, which [`Numbers`] remembers.
    fn read(&self, letter: u8, numbers: &mut Numbers<'_>) -> Option<Self::Row>;

    /// Obeys a row.
    ///
    /// # Errors
    /// The reason. Then nothing has changed.
    fn carry_out(&mut self, row: &Self::Row) -> Result<Said, Fault<Self::Reason>>;

    /// Number `n` of a report, counted from 0; `None` past the last.
    fn number(&mut self, n: u8) -> Option<i64> {
        let _ = n;
        None
    }

    /// Whether anything moves, or is about to.
    fn is_busy(&mut self) -> bool;

    /// The position of an axis, which is counted from 0; `None` if it is not known.
    fn position(&mut self, axis: u8) -> Option<i64>;

    /// Sets the present position of an axis to 0. Called only while nothing moves.
    fn set_zero(&mut self, axis: u8);

    /// Makes all positions unknown, as after a reset in motion. Called only while nothing moves.
    fn mark_unknown(&mut self);

    /// Brakes all axes to rest, as the program can; the positions stay known.
    fn stop(&mut self);

    /// Stops all axes at once; the position of an axis that moved is unknown from then on.
    fn kill(&mut self);

    /// Does a piece of the program's work between two lines. Call it as often as possible.
    fn poll(&mut self);
}

/// The answer to a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Said {
    /// `Y`: the row was obeyed.
    Yes,
    /// A number.
    Number(i64),
    /// The numbers of [`BoardProgram::number`], separated by commas.
    Report,
}

/// The answer that is being sent.
#[derive(Clone, Copy, Debug)]
enum Answer<R> {
    Nothing,
    Letter(u8),
    Number(i64),
    Report,
    About,
    Fault(Fault<R>),
}

/// The slave's half of a program's line: one answer to each line. It holds no clock and does no
/// I/O.
///
/// Once a line with a checksum was obeyed, a row without one is refused, until a common line
/// without one is obeyed: a row acts at once, and a row that has lost its `*` would be another row.
#[derive(Clone, Debug)]
pub struct ProgramSlave<R> {
    answer: Answer<R>,
    /// The number of parts of the answer that were begun.
    part: u8,
    text: Text,
    minus: bool,
    number: Decimal,
    tail: Tail,
    /// The master uses checksums: a row without one has lost its `*`.
    sums: bool,
}

impl<R: OwnFault> ProgramSlave<R> {
    /// The state at power-up.
    pub const fn new() -> ProgramSlave<R> {
        ProgramSlave {
            answer: Answer::Nothing,
            part: 0,
            text: text!(""),
            minus: false,
            number: Decimal::NONE,
            tail: Tail::NONE,
            sums: false,
        }
    }

    /// Whether part of the last answer is still to be sent.
    pub fn is_answering(&self) -> bool {
        !matches!(self.answer, Answer::Nothing) || self.tail.is_left()
    }

    /// Obeys a complete line and prepares its answer; then the next line may come. Not to be called
    /// while the slave [answers](ProgramSlave::is_answering).
    #[inline(never)]
    pub fn obey<P, const LONGEST: usize>(&mut self, line: &mut Incoming<LONGEST>, program: &mut P)
    where
        P: BoardProgram<Reason = R>,
    {
        let (line, damaged) = line.take();
        let summed = sum::is_wanted(line);
        self.tail = Tail::new(summed);
        self.part = 0;
        let row = matches!(line, [ROW, ..]);
        let line = if summed && !damaged { sum::checked(line) } else { Ok(line) };
        match line {
            // `:G4*33` without its `*` is `:G433`.
            Ok(_) if row && self.sums && !summed => self.answer = Answer::Fault(Fault::Sum),
            Ok(line) if !damaged => answer(line, program, &mut self.answer),
            Ok(_) if !summed => self.answer = Answer::Fault(Fault::Line),
            _ => self.answer = Answer::Fault(Fault::Sum),
        }
        if !matches!(self.answer, Answer::Fault(_)) {
            self.sums = summed;
        }
    }

    /// The next byte of the answer, including the CR; `None` when the answer is complete. A number
    /// is read at the moment when it is due.
    #[inline(never)]
    pub fn next_byte<P: BoardProgram<Reason = R>>(&mut self, program: &mut P) -> Option<u8> {
        if let Some(byte) = self.tail.next() {
            return Some(byte);
        }
        let byte = self.plain(program)?;
        Some(self.tail.pass(byte))
    }

    /// The next byte, without the checksum.
    fn plain<P: BoardProgram<Reason = R>>(&mut self, program: &mut P) -> Option<u8> {
        loop {
            if core::mem::take(&mut self.minus) {
                return Some(b'-');
            }
            if let Some(byte) = self.number.next() {
                return Some(byte);
            }
            if let Some(byte) = self.text.byte(0) {
                self.text = self.text.rest();
                return Some(byte);
            }
            let part = self.part;
            self.part = part.wrapping_add(1);
            let (mut before, mut text) = (b',', None);
            let number = match &self.answer {
                Answer::Nothing => return None,
                Answer::Letter(letter) if part == 0 => return Some(*letter),
                Answer::Letter(_) => None,
                Answer::Number(number) => Some(*number).filter(|_| part == 0),
                Answer::Report => program.number(part),
                Answer::About => match program.about(part) {
                    Some(Piece::Text(word)) => {
                        text = Some(word);
                        None
                    }
                    Some(Piece::Number(number)) => {
                        before = 0;
                        Some(number.into())
                    }
                    None => None,
                },
                Answer::Fault(fault) => match part.checked_sub(2) {
                    Some(n) => {
                        if n == 0 {
                            before = b' ';
                        }
                        fault.number(n)
                    }
                    None => {
                        text = Some(if part == 0 { text!("E ") } else { fault.word() });
                        None
                    }
                },
            };
            if let Some(text) = text {
                self.text = text;
                continue;
            }
            let Some(number) = number else {
                self.answer = Answer::Nothing;
                return Some(CR);
            };
            self.number.set(&mut number.unsigned_abs().to_le_bytes());
            self.minus = number < 0;
            if part != 0 && before != 0 {
                return Some(before);
            }
        }
    }
}

impl<R: OwnFault> Default for ProgramSlave<R> {
    fn default() -> Self {
        ProgramSlave::new()
    }
}

/// Obeys a line without its end and its checksum, and writes the answer in place: a second `Answer`
/// would take as much of a small chip's stack again.
///
/// Reading a row and the common lines have stack frames of their own, so that the start of a motor
/// has the stack for itself.
#[inline(always)]
fn answer<P: BoardProgram>(line: &[u8], program: &mut P, to: &mut Answer<P::Reason>) {
    match line {
        [] => *to = Answer::Fault(Fault::Line),
        [ROW, row @ ..] => match &read_row(row, |letter, numbers| program.read(letter, numbers)) {
            Ok(row) => match program.carry_out(row) {
                Ok(Said::Yes) => *to = Answer::Letter(b'Y'),
                Ok(Said::Number(number)) => *to = Answer::Number(number),
                Ok(Said::Report) => *to = Answer::Report,
                Err(fault) => *to = Answer::Fault(fault),
            },
            Err(fault) => *to = Answer::Fault(*fault),
        },
        [letter, rest @ ..] => common(*letter, rest, program, to),
    }
}

/// Obeys a line that every program has.
#[inline(never)]
fn common<P: BoardProgram>(letter: u8, rest: &[u8], program: &mut P, to: &mut Answer<P::Reason>) {
    let axis = match letter {
        b'V' | b'I' => match only(rest) {
            Some(number) if (1..=program.axes().into()).contains(&number) => {
                (number as u8).wrapping_sub(1)
            }
            Some(_) => return *to = Answer::Fault(Fault::Axis),
            None => return *to = Answer::Fault(Fault::Line),
        },
        _ if !rest.is_empty() => return *to = Answer::Fault(Fault::Line),
        _ => 0,
    };
    *to = Answer::Letter(b'Y');
    match letter {
        b'V' => match program.position(axis) {
            Some(position) => *to = Answer::Number(position),
            None => *to = Answer::Fault(Fault::Uncertain),
        },
        b'I' if program.is_busy() => *to = Answer::Fault(Fault::Busy),
        b'I' => program.set_zero(axis),
        b'F' => *to = Answer::Letter(if program.is_busy() { b'B' } else { b'R' }),
        b'Z' => program.stop(),
        b'K' => program.kill(),
        b'?' => *to = Answer::About,
        _ => *to = Answer::Fault(Fault::Line),
    }
}

/// Reads a row without its `:`: the letter and all of its numbers.
///
/// # Errors
/// [`Fault::Line`], [`Fault::Range`]
#[inline(never)]
pub fn read_row<T, R>(
    row: &[u8],
    read: impl FnOnce(u8, &mut Numbers<'_>) -> Option<T>,
) -> Result<T, Fault<R>> {
    let Some((letter, rest)) = row.split_first() else { return Err(Fault::Line) };
    let mut numbers = Numbers::of(rest);
    match read(*letter, &mut numbers) {
        Some(row) if numbers.is_end() => Ok(row),
        Some(_) => Err(Fault::Line),
        None => Err(numbers.fault()),
    }
}

/// The number, if the text is one number and nothing else.
fn only(digits: &[u8]) -> Option<i64> {
    let mut numbers = Numbers::of(digits);
    numbers.next().filter(|_| numbers.is_end())
}

#[cfg(test)]
mod tests;
