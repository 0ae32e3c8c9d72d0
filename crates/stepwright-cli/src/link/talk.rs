//! A line of text to a board, and its answer.

use std::io;
use std::time::Duration;

use super::Link;
use crate::failure::Failure;
use crate::programs;

/// A board answers within milliseconds.
const PATIENCE: Duration = Duration::from_millis(500);
/// How often it is asked before it counts as silent: one that the port's opening has reset
/// passes its boot loader first.
pub const TRIES: usize = 8;
/// What there is to do about a board that was there a moment ago.
const LOST: &str = "is it still plugged in? what it plays goes on; a reset ends it";

/// Lines that end with a carriage return, one answer each.
pub struct Talk {
    link: Box<dyn Link>,
}

impl Talk {
    /// Over this link.
    pub fn new(link: Box<dyn Link>) -> Talk {
        Talk { link }
    }

    /// How to call the board in a sentence.
    pub fn name(&self) -> String {
        self.link.name()
    }

    /// The link.
    pub fn link(&mut self) -> &mut dyn Link {
        self.link.as_mut()
    }

    fn lost(&self, error: &io::Error) -> Failure {
        Failure::new(format!("{} is gone: {error}", self.link.name())).hint(LOST)
    }

    /// Sends these bytes.
    pub fn send(&mut self, text: &str) -> Result<(), Failure> {
        self.link.write(text.as_bytes()).map_err(|error| self.lost(&error))
    }

    /// The next line of the board's; `None` if none comes for a while.
    pub fn line(&mut self) -> Result<Option<String>, Failure> {
        let (begun, mut text) = (self.link.now(), Vec::new());
        loop {
            let left = PATIENCE.saturating_sub(self.link.now() - begun);
            let mut byte = [0];
            let count = self.link.read(&mut byte, left).map_err(|error| self.lost(&error))?;
            match byte {
                _ if count == 0 && left.is_zero() => return Ok(None),
                _ if count == 0 => {}
                [b'\r'] => return Ok(Some(String::from_utf8_lossy(&text).into_owned())),
                [byte] => text.push(byte),
            }
        }
    }

    /// Says a line, and hears its answer.
    pub fn ask(&mut self, line: &str) -> Result<String, Failure> {
        self.send(&format!("{line}\r"))?;
        let answer = self.line()?;
        answer.ok_or_else(|| self.silent())
    }

    /// It has answered, and does not any more.
    pub fn silent(&self) -> Failure {
        Failure::new(format!("{} does not answer any more", self.name())).hint(LOST)
    }

    /// Lets time pass. Nothing is expected from the board.
    pub fn rest(&mut self, time: Duration) -> Result<(), Failure> {
        let end = self.link.now() + time;
        loop {
            // Asked once: time goes on between two questions.
            let left = end.saturating_sub(self.link.now());
            if left.is_zero() {
                return Ok(());
            }
            self.link.read(&mut [0; 32], left).map_err(|error| self.lost(&error))?;
        }
    }

    /// Asks the board what it is; its answer, which begins with the greeting that is wanted.
    ///
    /// # Errors
    /// It is silent, or runs another program; `program` names the one to flash, by the board's answer.
    pub fn meet(
        &mut self,
        wanted: &str,
        program: impl Fn(&str) -> &'static str,
    ) -> Result<String, Failure> {
        let at = self.name();
        for _ in 0..TRIES {
            // An empty line ends what was left of another.
            self.send("\r?\r")?;
            while let Some(answer) = self.line()? {
                if programs::is_wanted(&at, &answer, wanted, &program)?.is_some() {
                    return Ok(answer);
                }
            }
        }
        Err(Failure::new(format!("{at} does not answer")).hint(programs::flash("", program(""))))
    }
}
