//! Boards that run another program than the controller: Austin's laws, the timed driver or motor cycles.
//!
//! ```text
//!   LawSession    ┐
//!   TimedSession  ├─ ProgramSession<Row> ─► Session ─► a row, its answer, read
//!   CycleSession  ┘
//! ```
//!
//! A row is a type of the program's own crate, so every row that is sent can be read by the board. A row that
//! noise has spoiled is repeated if that is harmless.

mod cycles;
mod laws;
mod places;
mod timed;

use std::fmt;
use std::marker::PhantomData;
use std::time::Duration;

use stepwright_protocol::{Fault, OwnFault};

use crate::conversation::LinkError;
use crate::link::Link;
use crate::session::Session;

pub use cycles::{CycleProblem, CycleSession};
pub use laws::{LawProblem, LawSession};
pub use places::{ask, places, wait_for_rest};
pub use timed::{TimedProblem, TimedSession};

/// A row of a program's serial line.
pub trait ProgramRow: Copy + fmt::Debug + fmt::Display {
    /// The first word of the board's answer to `?`.
    const GREETING: &'static str;

    /// The program's own reasons to refuse a row.
    type Reason: OwnFault + fmt::Debug + fmt::Display;

    /// Whether repeating the row changes nothing.
    fn is_harmless_twice(&self) -> bool;
}

/// Why a row was not obeyed.
#[derive(Debug)]
pub enum RowProblem<L: ProgramRow> {
    /// The conversation has ended. Moving motors go on.
    Lost(LinkError),
    /// The board runs another program: its answer to `?`.
    OtherProgram(String),
    /// The board refused the row, and changed nothing.
    Refused {
        /// The row.
        row: L,
        /// The reason.
        reason: Fault<L::Reason>,
    },
    /// Noise spoiled the answer: whether the row was obeyed is unknown.
    Noise {
        /// The row.
        row: L,
    },
    /// The answer does not fit the row: the board runs another version of the program.
    Nonsense {
        /// The row.
        row: L,
        /// The answer.
        answer: String,
    },
}

impl<L: ProgramRow> fmt::Display for RowProblem<L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RowProblem::Lost(trouble) => write!(f, "{trouble}; a motor may be moving"),
            RowProblem::OtherProgram(about) => {
                write!(f, "the board runs another program: {about}")
            }
            RowProblem::Refused { row, reason } => write!(f, "{row} was refused: {reason}"),
            RowProblem::Noise { row } => write!(f, "noise spoiled the answer to {row}"),
            RowProblem::Nonsense { row, answer } => {
                write!(f, "{row} was answered {answer:?}: another version of the program?")
            }
        }
    }
}

impl<L: ProgramRow> std::error::Error for RowProblem<L> {}

impl<L: ProgramRow> From<LinkError> for RowProblem<L> {
    fn from(trouble: LinkError) -> RowProblem<L> {
        RowProblem::Lost(trouble)
    }
}

/// A session with a board that runs the program of these rows.
pub struct ProgramSession<L> {
    session: Session,
    about: String,
    rows: PhantomData<L>,
}

impl<L: ProgramRow> ProgramSession<L> {
    /// Meets the board at the other end of a line.
    ///
    /// # Errors
    /// [`RowProblem::OtherProgram`]; [`RowProblem::Lost`] if no board answers within 4 s.
    pub fn on(link: Box<dyn Link>) -> Result<Self, RowProblem<L>> {
        let mut session = Session::new(link);
        let about = session.meet_program()?;
        Self::of(session, about)
    }

    /// Takes a session that has met the board, and the board's answer to `?`.
    ///
    /// # Errors
    /// [`RowProblem::OtherProgram`]
    pub fn of(session: Session, about: String) -> Result<Self, RowProblem<L>> {
        if about.split(' ').next() == Some(L::GREETING) {
            Ok(ProgramSession { session, about, rows: PhantomData })
        } else {
            Err(RowProblem::OtherProgram(about))
        }
    }

    /// The board's answer to `?`.
    pub fn about(&self) -> &str {
        &self.about
    }

    /// The kind of board: `uno`, `mega`, `virtual`.
    pub fn board(&self) -> &str {
        self.about.split(' ').nth(1).unwrap_or_default()
    }

    /// The value of `word=value` in the board's answer to `?`.
    pub fn word(&self, word: &str) -> Option<&str> {
        value(&self.about, word)
    }

    /// Whether the board has this word in its list `can=`.
    pub fn can(&self, word: &str) -> bool {
        self.word("can").is_some_and(|all| all.split(',').any(|can| can == word))
    }

    /// Ticks of its timer per second; 0 if the board does not tell.
    pub fn hz(&self) -> u32 {
        self.word("hz").and_then(|hz| hz.parse().ok()).unwrap_or(0)
    }

    /// The name of the board in a sentence.
    pub fn name(&self) -> String {
        self.session.name()
    }

    /// The session, for the rows common to all programs.
    pub fn session(&mut self) -> &mut Session {
        &mut self.session
    }

    /// Lets time pass.
    ///
    /// # Errors
    /// [`RowProblem::Lost`]
    pub fn pause(&mut self, time: Duration) -> Result<(), RowProblem<L>> {
        Ok(self.session.pause(time)?)
    }

    /// Says a row, and returns its answer.
    ///
    /// # Errors
    /// [`RowProblem::Noise`], [`RowProblem::Lost`]
    pub fn ask(&mut self, row: &L) -> Result<String, RowProblem<L>> {
        let answer = self.session.row(&row.to_string(), row.is_harmless_twice())?;
        answer.ok_or(RowProblem::Noise { row: *row })
    }

    /// Says a row that the board has to obey.
    ///
    /// # Errors
    /// All but [`RowProblem::OtherProgram`].
    pub fn say(&mut self, row: &L) -> Result<(), RowProblem<L>> {
        let answer = self.ask(row)?;
        obeyed(row, &answer)
    }
}

/// The value of `word=value` in an answer to `?`.
fn value<'a>(about: &'a str, word: &str) -> Option<&'a str> {
    let mut pairs = about.split(' ').filter_map(|pair| pair.split_once('='));
    pairs.find(|(name, _)| *name == word).map(|(_, value)| value)
}

/// Checks that a row was obeyed.
fn obeyed<L: ProgramRow>(row: &L, answer: &str) -> Result<(), RowProblem<L>> {
    if answer == "Y" {
        return Ok(());
    }
    let row = *row;
    Err(match Fault::read(answer.as_bytes()) {
        Some(reason) => RowProblem::Refused { row, reason },
        None => RowProblem::Nonsense { row, answer: answer.to_owned() },
    })
}
