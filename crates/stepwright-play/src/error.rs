//! The error of a file that is not played, or not to its end.

use std::error::Error;
use std::fmt;

use stepwright_cyclefile::FileError;
use stepwright_host::LinkError;
use stepwright_plan::gcode::{BoardRefusal, JobError};

use crate::gcode::BOARD;

/// The position of a mistake in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayPlace {
    /// What is wrong there, without the file and its line.
    pub what: String,
    /// The line, from 1.
    pub line: usize,
    /// The byte of the line, from 1.
    pub column: Option<u16>,
    /// The motor, by its name in the file.
    pub motor: Option<String>,
}

/// The error of a file that is not played, or not to its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlayError {
    /// What is wrong, with its position.
    pub message: String,
    /// What can be done about it.
    pub hint: Option<String>,
    /// The position in the file, if there is one. Boxed, because errors are rare.
    pub place: Option<Box<PlayPlace>>,
    /// Whether the user has interrupted it.
    pub interrupted: bool,
}

impl PlayError {
    /// A failure or a refusal.
    pub fn new(message: impl Into<String>) -> PlayError {
        PlayError { message: message.into(), hint: None, place: None, interrupted: false }
    }

    /// An interruption by the user.
    pub fn interrupted(message: impl Into<String>) -> PlayError {
        PlayError { interrupted: true, ..PlayError::new(message) }
    }

    /// The error for a failed conversation with this board.
    pub fn lost(name: &str, trouble: &LinkError) -> PlayError {
        match trouble {
            LinkError::Killed | LinkError::Ended => {
                PlayError::interrupted(format!("{name}: interrupted"))
            }
            LinkError::Silent => PlayError::new(format!("{name} does not answer any more"))
                .hint("look at its cable and its power, then at `stepwright status`"),
            LinkError::Gone(_) => PlayError::new(format!("{name}: {trouble}"))
                .hint("was it unplugged? Plug it in and try again"),
            LinkError::Program(_) => PlayError::new(format!("{name}: {trouble}"))
                .hint("`stepwright flash` writes the controller"),
        }
    }

    /// The error of a job with this name.
    pub fn job(name: &str, error: &JobError) -> PlayError {
        let (what, line, column) = match error {
            JobError::Code(code) => (code.fault.to_string(), code.line, Some(code.column)),
            JobError::Move(0, why) => return PlayError::new(format!("the axes: {why}")),
            JobError::Move(line, why) => (why.to_string(), *line, None),
        };
        PlayError::new(format!("{name}: {error}")).at(what, line, column)
    }

    /// The error of a job that the virtual board refuses.
    pub fn refused_job(name: &str, refused: &BoardRefusal) -> PlayError {
        let what = refused.words(BOARD);
        PlayError::new(format!("{name}: {what}")).at(what, refused.line, None)
    }

    /// Adds the position of what is wrong.
    pub(crate) fn at(self, what: String, line: u32, column: Option<u16>) -> PlayError {
        let place = PlayPlace { what, line: line as usize, column, motor: None };
        PlayError { place: Some(Box::new(place)), ..self }
    }

    /// Adds what can be done about it.
    pub fn hint(self, hint: impl Into<String>) -> PlayError {
        PlayError { hint: Some(hint.into()), ..self }
    }

    /// Adds the motor that it is about.
    pub fn motor(mut self, name: &str) -> PlayError {
        if let Some(place) = &mut self.place {
            place.motor = Some(name.to_owned());
        }
        self
    }
}

impl fmt::Display for PlayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl Error for PlayError {}

impl From<FileError> for PlayError {
    fn from(error: FileError) -> PlayError {
        let place = PlayPlace { what: error.what, line: error.line, column: None, motor: None };
        PlayError {
            message: error.message,
            hint: error.hint,
            place: Some(Box::new(place)),
            interrupted: false,
        }
    }
}
