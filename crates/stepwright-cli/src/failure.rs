//! The error of a command that could not do what was requested.

use std::fmt::{self, Display};
use std::io::{self, ErrorKind};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::json;
use stepwright::OutOfRange;
use stepwright::profile::Unfit;
use stepwright_plan::PlanError;
use stepwright_units::UnitError;

use crate::{interrupt, say};

/// A refusal or a failure: what is wrong, and what to do about it.
///
/// Every subcommand is `run(args) -> Result<(), Failure>`; `main` reports it on
/// standard error and turns it into the exit status:
///
/// | status | meaning |
/// | --- | --- |
/// | 0 | done |
/// | 1 | refused by the board, the file or the calculation, or it failed |
/// | 2 | invalid command line, whatever the board: nothing was touched |
/// | 130 | Ctrl-C or another signal ended it before it was done |
#[derive(Debug)]
pub struct Failure {
    message: String,
    hint: Option<String>,
    status: u8,
    place: Option<Box<Place>>,
}

/// The position of a mistake in a file, for programs.
#[derive(Clone, Debug)]
pub struct Place {
    /// What is wrong there, without the file and its line.
    pub what: String,
    /// The line, from 1.
    pub line: usize,
    /// The byte of the line, from 1.
    pub column: Option<u16>,
    /// The motor, by its name in the file.
    pub motor: Option<String>,
}

/// The message alone, without the hint, as for any other error.
impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl Failure {
    /// A refusal or a failure: status 1.
    pub fn new(message: impl Into<String>) -> Failure {
        Failure { message: message.into(), hint: None, status: 1, place: None }
    }

    /// An invalid command line: status 2.
    pub fn usage(message: impl Into<String>) -> Failure {
        Failure { status: 2, ..Failure::new(message) }
    }

    /// The command was ended by Ctrl-C or another signal before it was done: status 130, as in
    /// shells.
    pub fn interrupted(message: impl Into<String>) -> Failure {
        Failure::new(message).status(interrupt::STATUS)
    }

    /// Sets another exit status.
    pub fn status(self, status: u8) -> Failure {
        Failure { status, ..self }
    }

    /// A file or a device that could not be used.
    pub fn file(what: &str, path: &Path, error: &dyn Display) -> Failure {
        Failure::new(format!("can't {what} {}: {error}", path.display()))
    }

    /// A recording that could not be written at its end.
    pub fn recording(error: io::Error) -> Failure {
        error.downcast().unwrap_or_else(|error| Failure::new(error.to_string()))
    }

    /// Adds what the user can do about it.
    pub fn hint(self, hint: impl Into<String>) -> Failure {
        Failure { hint: Some(hint.into()), ..self }
    }

    /// Adds the position in a file.
    pub fn at(self, what: String, line: usize) -> Failure {
        Failure { place: Some(Box::new(Place { what, line, column: None, motor: None })), ..self }
    }

    /// Adds the column of the line.
    pub fn column(mut self, column: u16) -> Failure {
        if let Some(place) = &mut self.place {
            place.column = Some(column);
        }
        self
    }

    /// Adds the motor that it is about.
    pub fn motor(mut self, name: &str) -> Failure {
        if let Some(place) = &mut self.place {
            place.motor = Some(name.to_owned());
        }
        self
    }

    /// The position in a file, if the failure has one.
    pub fn place(&self) -> Option<&Place> {
        self.place.as_deref()
    }

    /// What is wrong.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What can be done about it.
    pub fn hinted(&self) -> Option<&str> {
        self.hint.as_deref()
    }

    /// Prints the failure on standard error, and returns the exit status. For programs it is one
    /// line of JSON, the last line of standard error.
    pub fn report(&self) -> ExitCode {
        if is_json() {
            let hint = self.hint.as_deref();
            let mut said = json!({ "error": self.message, "hint": hint, "status": self.status });
            if let Some(place) = self.place() {
                said["line"] = json!(place.line);
                if let Some(column) = place.column {
                    said["column"] = json!(column);
                }
                said["motor"] = json!(place.motor);
            }
            say::note(said);
            return ExitCode::from(self.status);
        }
        say::note(format_args!("error: {}", self.message));
        if let Some(hint) = &self.hint {
            say::note(format_args!(" hint: {hint}"));
        }
        ExitCode::from(self.status)
    }
}

/// Whether failures are printed as JSON.
static JSON: AtomicBool = AtomicBool::new(false);

/// Prints failures as JSON from now on: the command line has `--format json`.
pub fn say_json() {
    JSON.store(true, Ordering::Relaxed);
}

/// Whether failures are printed as JSON.
pub fn is_json() -> bool {
    JSON.load(Ordering::Relaxed)
}

/// An invalid command line, from clap's message: what is wrong, then what would be right.
impl From<clap::Error> for Failure {
    fn from(error: clap::Error) -> Failure {
        let text = error.to_string();
        let (what, todo) = text.split_once("\n\n").unwrap_or((&text, ""));
        let what = what.strip_prefix("error: ").unwrap_or(what).trim();
        let todo: Vec<_> = todo.split_whitespace().collect();
        Failure::usage(what.split_whitespace().collect::<Vec<_>>().join(" ")).hint(todo.join(" "))
    }
}

impl From<OutOfRange> for Failure {
    fn from(error: OutOfRange) -> Failure {
        Failure::new(error.to_string())
    }
}

impl From<Unfit> for Failure {
    fn from(unfit: Unfit) -> Failure {
        Failure::new(unfit.what()).hint(unfit.remedy())
    }
}

impl From<PlanError> for Failure {
    fn from(error: PlanError) -> Failure {
        let failure = Failure::new(error.to_string());
        match error {
            PlanError::Unfit(unfit) => unfit.into(),
            PlanError::TooFast { .. } => failure.hint("lower --top-speed or raise --timer-hz"),
            PlanError::TooMany { most, .. } => {
                failure.status(2).hint(format!("every step is looked at: give {most} or fewer"))
            }
        }
    }
}

impl From<UnitError> for Failure {
    fn from(error: UnitError) -> Failure {
        Failure::usage(error.to_string()).hint(match &error {
            UnitError::NoMillimetres { .. } => {
                "add --mm-per-rev, for example --mm-per-rev 40 for a GT2 belt on 20 teeth"
            }
            UnitError::Speed { name, is_zero: true, .. } if name == "the speed" => {
                "0 is no motion; `stepwright stop` brakes a motor that runs"
            }
            UnitError::Speed { is_zero: true, .. } => "0 is no motion: 0.001 steps/s is the least",
            UnitError::Speed { .. } => "are the unit and --steps-per-rev right?",
            UnitError::Accel { .. } => {
                "an acceleration is 0.001 to 100000000 steps/s²; for none at all, set \
                 --start-speed to the top speed"
            }
            UnitError::Jerk { .. } => {
                "a jerk is 0.001 to 10^15 steps/s³; for no limit of it, leave it out"
            }
        })
    }
}

/// The result of writing to standard output. A reader that closes early (`| head`) is no failure.
pub fn unless_closed(written: io::Result<()>) -> Result<(), Failure> {
    match written {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(format!("can't write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}
