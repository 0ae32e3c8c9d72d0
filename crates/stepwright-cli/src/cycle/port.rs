//! `cycle FILE --port`: the line to a board that runs the program `cycles`.

use std::time::Duration;

use stepwright::drive::Arduino;
use stepwright_cycle::line::{CycleFault, CycleLine, CycleReport, NAME};

use crate::failure::Failure;
use crate::order::target;
use stepwright_host::Session;
use stepwright_host::link::Link;
use stepwright_protocol::Fault;

/// A board that plays cycles.
pub struct Board {
    session: Session,
    /// Its name: uno or mega.
    pub name: String,
    pub hz: u32,
    /// Motors, and legs of all series.
    pub motors: usize,
    pub legs: usize,
    can: Vec<String>,
}

impl Board {
    /// Meets the board at the end of a line.
    pub fn meet(link: Box<dyn Link>) -> Result<Board, Failure> {
        // A signal ends the watching, and the cycle is finished then.
        let mut session = Session::new(link);
        let answer = target::met_program(&mut session, NAME, |_| "cycles")?;
        let mut words = answer.split(' ').skip(1);
        let name = words.next().unwrap_or("").to_owned();
        let mut board = Board { session, name, hz: 0, motors: 0, legs: 0, can: Vec::new() };
        for word in words {
            let number = |text: &str| text.parse().unwrap_or(0);
            match word.split_once('=') {
                Some(("hz", hz)) => board.hz = hz.parse().unwrap_or(0),
                Some(("axes", motors)) => board.motors = number(motors),
                Some(("legs", legs)) => board.legs = number(legs),
                Some(("can", all)) => board.can = all.split(',').map(str::to_owned).collect(),
                _ => {}
            }
        }
        Ok(board)
    }

    /// Which Arduino it is.
    pub fn arduino(&self) -> Arduino {
        if self.name == "mega" { Arduino::Mega } else { Arduino::Uno }
    }

    /// Whether it has this word among what it can.
    pub fn can(&self, word: &str) -> bool {
        self.can.iter().any(|can| can == word)
    }

    /// How to call it in a sentence.
    pub fn called(&self) -> String {
        self.session.name()
    }

    /// Lets time pass.
    pub fn rest(&mut self, time: Duration) -> Result<(), Failure> {
        let lost = self.lost();
        self.session.pause(time).map_err(lost)
    }

    /// The board was there a moment ago.
    fn lost(&self) -> impl FnOnce(stepwright_host::LinkError) -> Failure + use<> {
        let name = self.called();
        move |trouble| {
            target::lost(&name, &trouble)
                .hint("what it plays goes on; a reset of the board ends it")
        }
    }

    /// What a line is answered. It may be said twice: one that was spoiled is.
    fn ask(&mut self, line: CycleLine) -> Result<String, Failure> {
        let lost = self.lost();
        let answer = self.session.row(&line.to_string(), true).map_err(lost)?;
        let silent = self.lost();
        answer.ok_or_else(|| silent(stepwright_host::LinkError::Silent))
    }

    /// Says a line that is to be obeyed.
    ///
    /// # Errors
    /// The inner one is the board's refusal.
    pub fn say(&mut self, line: CycleLine) -> Result<Result<(), Fault<CycleFault>>, Failure> {
        let answer = self.ask(line)?;
        if answer == "Y" {
            return Ok(Ok(()));
        }
        Fault::read(answer.as_bytes()).map(Err).ok_or_else(|| self.nonsense(&answer))
    }

    /// How it is.
    pub fn look(&mut self) -> Result<CycleReport, Failure> {
        let answer = self.ask(CycleLine::Look)?;
        CycleReport::read(answer.as_bytes()).ok_or_else(|| self.nonsense(&answer))
    }

    fn nonsense(&self, answer: &str) -> Failure {
        Failure::new(format!("{} answered {answer:?}, which is no answer", self.called()))
            .hint("does it run the same version of the program as this command?")
    }

    /// A line that the board refuses, though the file is fine.
    pub fn unfit(&self, line: CycleLine, fault: Fault<CycleFault>) -> Failure {
        Failure::new(format!("{} refused the line {line}: {fault}", self.called()))
            .hint("does it run the same version of the program as this command?")
    }
}
