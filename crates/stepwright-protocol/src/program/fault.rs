//! The reasons why a line is refused: a word and its numbers.

use super::Numbers;
use crate::flash::{Text, text};

/// A program's own reasons to refuse a row.
pub trait OwnFault: Copy {
    /// The word on the line, of lower-case letters and `-`.
    fn word(&self) -> Text;

    /// Number `n` after the word, counted from 0; `None` past the last.
    fn number(&self, n: u8) -> Option<i64>;

    /// The reason with this word and these numbers.
    fn read(word: &[u8], numbers: &mut Numbers<'_>) -> Option<Self>;
}

/// The reason why a line of a program is refused. The words of the controller mean what
/// [`Refusal`](crate::Refusal) says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault<R> {
    /// `line`: no such line, a wrong count of numbers, or a damaged line.
    Line,
    /// `sum`: the checksum does not match the line.
    Sum,
    /// `axis`: the board has no such axis.
    Axis,
    /// `busy`: the line is only for a board at rest.
    Busy,
    /// `uncertain`: the position is not known.
    Uncertain,
    /// `range NUMBER,LEAST,MOST`: a number is outside its range.
    Range {
        /// The number's place in the line, from 1.
        number: u8,
        /// The smallest allowed value.
        least: i64,
        /// The largest allowed value.
        most: i64,
    },
    /// A reason of the program's own.
    Own(R),
}

/// Common word `n`, in the order of the reasons; past the last an empty text.
fn common(n: u8) -> Text {
    text!("line\0sum\0axis\0busy\0uncertain\0range\0").word(n)
}

impl<R: OwnFault> Fault<R> {
    /// The word on the line.
    pub(super) fn word(&self) -> Text {
        common(match self {
            Fault::Line => 0,
            Fault::Sum => 1,
            Fault::Axis => 2,
            Fault::Busy => 3,
            Fault::Uncertain => 4,
            Fault::Range { .. } => 5,
            Fault::Own(own) => return own.word(),
        })
    }

    /// Number `n` after the word.
    pub(super) fn number(&self, n: u8) -> Option<i64> {
        match self {
            Fault::Range { number, least, most } => match n {
                0 => Some((*number).into()),
                1 => Some(*least),
                2 => Some(*most),
                _ => None,
            },
            Fault::Own(own) => own.number(n),
            _ => None,
        }
    }

    /// Reads an answer; `None` if it is not a refusal of this program.
    pub fn read(answer: &[u8]) -> Option<Fault<R>> {
        let [b'E', b' ', said @ ..] = answer else { return None };
        let end = said.iter().position(|byte| *byte == b' ').unwrap_or(said.len());
        let (word, numbers) = said.split_at_checked(end)?;
        let mut numbers = Numbers::of(numbers.get(1..).unwrap_or_default());
        let fault = match (0..6).find(|n| common(*n).is(word)) {
            Some(0) => Fault::Line,
            Some(1) => Fault::Sum,
            Some(2) => Fault::Axis,
            Some(3) => Fault::Busy,
            Some(4) => Fault::Uncertain,
            Some(_) => {
                let number = numbers.up_to(u8::MAX)?;
                Fault::Range { number, least: numbers.next()?, most: numbers.next()? }
            }
            None => Fault::Own(R::read(word, &mut numbers)?),
        };
        numbers.is_end().then_some(fault)
    }
}

impl<R: core::fmt::Display> core::fmt::Display for Fault<R> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Fault::Line => f.write_str("it does not know the line"),
            Fault::Sum => f.write_str("the line was spoiled on its way"),
            Fault::Axis => f.write_str("it has no such axis"),
            Fault::Busy => f.write_str("it moves"),
            Fault::Uncertain => f.write_str("the position is not known"),
            Fault::Range { number, least, most } => {
                write!(f, "number {number} of the line is {least} to {most}")
            }
            Fault::Own(own) => own.fmt(f),
        }
    }
}
