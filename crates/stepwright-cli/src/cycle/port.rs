//! `cycle FILE --port`: the line to a board that runs the program `cycles`.

use std::io;
use std::time::Duration;

use stepwright::drive::Arduino;
use stepwright_cycle::line::{CycleLine, CycleReport, LineFault, NAME};
use stepwright_protocol::crc;

use crate::failure::Failure;
use crate::link::Link;

/// A board answers within milliseconds.
const PATIENCE: Duration = Duration::from_millis(500);
/// How often it is asked before it counts as silent: one that the port's opening has reset
/// passes its boot loader first.
const TRIES: usize = 8;

/// A board that plays cycles.
pub struct Board {
    link: Box<dyn Link>,
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
        let (name, can) = (String::new(), Vec::new());
        let mut board = Board { link, name, hz: 0, motors: 0, legs: 0, can };
        let at = board.link.name();
        for _ in 0..TRIES {
            // An empty line ends what was left of another.
            board.send("\r?\r")?;
            while let Some(answer) = board.line()? {
                let mut words = answer.split(' ');
                match words.next() {
                    Some(NAME) => {}
                    Some(other) if other.starts_with("stepwright") => {
                        let what = match other {
                            "stepwright" => "the controller".to_owned(),
                            other => format!("the program {other}"),
                        };
                        return Err(Failure::new(format!(
                            "{at} runs {what}, which plays no cycle files"
                        ))
                        .hint(
                            "flash the other program: `cargo xtask flash mega --program cycles \
                             --port PATH`; `--program slave` brings the controller back",
                        ));
                    }
                    _ => continue,
                }
                board.name = words.next().unwrap_or("").to_owned();
                for word in words {
                    let number = |text: &str| text.parse().unwrap_or(0);
                    match word.split_once('=') {
                        Some(("hz", hz)) => board.hz = hz.parse().unwrap_or(0),
                        Some(("motors", motors)) => board.motors = number(motors),
                        Some(("legs", legs)) => board.legs = number(legs),
                        Some(("can", all)) => {
                            board.can = all.split(',').map(str::to_owned).collect();
                        }
                        _ => {}
                    }
                }
                return Ok(board);
            }
        }
        Err(Failure::new(format!("{at} does not answer"))
            .hint("flash the program: `cargo xtask flash mega --program cycles --port PATH`"))
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
        self.link.name()
    }

    /// Lets time pass.
    pub fn rest(&mut self, time: Duration) {
        self.link.rest(time);
    }

    fn lost(&self, error: &io::Error) -> Failure {
        Failure::new(format!("{} is gone: {error}", self.link.name()))
            .hint("is it still plugged in? what it plays goes on; a reset ends it")
    }

    fn send(&mut self, text: &str) -> Result<(), Failure> {
        self.link.write(text.as_bytes()).map_err(|error| self.lost(&error))
    }

    /// The next line of the board's; `None` if none comes for a while.
    fn line(&mut self) -> Result<Option<String>, Failure> {
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

    /// What a line is answered, both with their checksums. A line may be said twice: one that
    /// was spoiled is.
    fn ask(&mut self, line: CycleLine) -> Result<String, Failure> {
        let text = line.to_string();
        let text = format!("{text}*{:02X}\r", text.bytes().fold(0, crc));
        for _ in 0..TRIES {
            self.send(&text)?;
            // What belongs to no checksum is an answer to the empty line, or was spoiled.
            while let Some(answer) = self.line()? {
                let Some((bare, sum)) = answer.rsplit_once('*') else { continue };
                if sum == format!("{:02X}", bare.bytes().fold(0, crc)) {
                    if bare.starts_with("E1,") {
                        break;
                    }
                    return Ok(bare.to_owned());
                }
                break;
            }
        }
        Err(Failure::new(format!("{} does not answer any more", self.link.name()))
            .hint("is it still plugged in? what it plays goes on; a reset ends it"))
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
        Failure::new(format!("{} answered {answer:?}, which is no answer", self.link.name()))
            .hint("does it run the same version of the program as this command?")
    }

    /// A line that the board refuses, though the file is fine.
    pub fn unfit(&self, line: CycleLine, fault: LineFault) -> Failure {
        Failure::new(format!("{} refused the line {line}: {fault}", self.link.name()))
            .hint("does it run the same version of the program as this command?")
    }
}
