//! `cycle FILE --port`: the line to a board that runs the program `cycles`.

use std::time::Duration;

use stepwright::drive::Arduino;
use stepwright_cycle::line::{CycleLine, CycleReport, LineFault, NAME};

use crate::failure::Failure;
use crate::talk::Talk;
use stepwright_host::link::Link;

/// A board that plays cycles.
pub struct Board {
    talk: Talk,
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
        let mut talk = Talk::new(link);
        let answer = talk.meet(NAME, |_| "cycles")?;
        let mut words = answer.split(' ').skip(1);
        let name = words.next().unwrap_or("").to_owned();
        let mut board = Board { talk, name, hz: 0, motors: 0, legs: 0, can: Vec::new() };
        for word in words {
            let number = |text: &str| text.parse().unwrap_or(0);
            match word.split_once('=') {
                Some(("hz", hz)) => board.hz = hz.parse().unwrap_or(0),
                Some(("motors", motors)) => board.motors = number(motors),
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
        self.talk.name()
    }

    /// Lets time pass.
    pub fn rest(&mut self, time: Duration) -> Result<(), Failure> {
        self.talk.rest(time)
    }

    /// What a line is answered, both with their checksums. A line may be said twice: one that
    /// was spoiled is.
    fn ask(&mut self, line: CycleLine) -> Result<String, Failure> {
        let answer =
            self.talk.ask_summed(&line.to_string(), true, |bare| bare.starts_with("E1,"))?;
        answer.ok_or_else(|| self.talk.silent())
    }

    /// Says a line that is to be obeyed.
    ///
    /// # Errors
    /// The inner one is the board's refusal.
    pub fn say(&mut self, line: CycleLine) -> Result<Result<(), LineFault>, Failure> {
        let answer = self.ask(line)?;
        if answer == "Y" {
            return Ok(Ok(()));
        }
        let fault = answer.strip_prefix('E').and_then(|text| LineFault::read(text.as_bytes()));
        fault.map(Err).ok_or_else(|| self.nonsense(&answer))
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
    pub fn unfit(&self, line: CycleLine, fault: LineFault) -> Failure {
        Failure::new(format!("{} refused the line {line}: {fault}", self.called()))
            .hint("does it run the same version of the program as this command?")
    }
}
