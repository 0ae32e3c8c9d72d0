//! A line of text to a board, and its answer.
//!
//! A board answers its lines one after another. So an answer that came too late is recognised,
//! however late it is: whoever missed one asks the board what it is, and takes nothing for an
//! answer before that to this question. Such an answer itself is known by how it begins.

use std::io;
use std::time::Duration;

use crate::failure::Failure;
use crate::programs;
use stepwright_host::link::Link;
use stepwright_protocol::crc;

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
    /// How the board begins to say what it is; empty before it was met.
    greeting: String,
    /// An answer that did not come may still come.
    owed: bool,
    /// Questions of what the board is whose answers have not come.
    asked: usize,
    /// Lines have checksums.
    sums: bool,
}

impl Talk {
    /// Over this link.
    pub fn new(link: Box<dyn Link>) -> Talk {
        Talk { link, greeting: String::new(), owed: false, asked: 0, sums: false }
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

    /// The next answer; `None` if none comes for a while.
    pub fn answer(&mut self) -> Result<Option<String>, Failure> {
        loop {
            match self.line()? {
                Some(answer) if self.is_greeting(&answer) => {
                    self.asked = self.asked.saturating_sub(1)
                }
                answer => {
                    self.owed = answer.is_none();
                    return Ok(answer);
                }
            }
        }
    }

    fn is_greeting(&self, answer: &str) -> bool {
        !self.greeting.is_empty() && answer.starts_with(&self.greeting)
    }

    /// Leaves all answers out that are to earlier lines, if one was missed.
    pub fn get_in_step(&mut self) -> Result<(), Failure> {
        if !self.owed {
            return Ok(());
        }
        self.send("?\r")?;
        self.asked += 1;
        let (mut heard, mut silent) = (false, 0);
        // One that answers so late is waited for three times as long.
        while silent < if heard { 3 * TRIES } else { TRIES } {
            let Some(answer) = self.line()? else {
                silent += 1;
                continue;
            };
            if self.is_greeting(&answer) {
                (heard, silent) = (true, 0);
                self.asked = self.asked.saturating_sub(1);
                self.owed = self.asked > 0;
                if !self.owed {
                    return Ok(());
                }
            }
        }
        if !heard {
            return Err(self.silent());
        }
        // The others were lost: to a boot loader, or on the line.
        (self.asked, self.owed) = (0, false);
        Ok(())
    }

    /// The next line of the board's; `None` if none comes for a while.
    fn line(&mut self) -> Result<Option<String>, Failure> {
        let (begun, mut text) = (self.link.now(), Vec::new());
        loop {
            let left = (begun + PATIENCE).saturating_sub(self.link.now());
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

    /// Says a line, and hears its answer. With checksums one that was damaged on its way is said
    /// again, and so is one that is harmless `twice` whose answer was; of any other `None` says so.
    pub fn ask(&mut self, line: &str, twice: bool) -> Result<Option<String>, Failure> {
        if self.sums {
            return self.ask_summed(line, twice, |bare| bare == "E sum");
        }
        self.ask_bare(line).map(Some)
    }

    /// Says a line, once, and hears its answer.
    fn ask_bare(&mut self, line: &str) -> Result<String, Failure> {
        self.get_in_step()?;
        self.send(&format!("{line}\r"))?;
        for _ in 0..TRIES {
            if let Some(answer) = self.answer()? {
                return Ok(answer);
            }
        }
        Err(self.silent())
    }

    /// Has lines have checksums from now on if the board answers one with one.
    pub fn use_sums(&mut self) -> Result<(), Failure> {
        for _ in 0..2 {
            self.get_in_step()?;
            self.send(&summed("?"))?;
            // Its greeting is taken for an answer to a question by `answer`.
            if let Some(answer) = self.line()? {
                self.sums = unsummed(&answer).is_some();
                return Ok(());
            }
            self.owed = true;
        }
        Ok(())
    }

    /// Says a line with its checksum until it is answered with one. A line that the board found
    /// damaged, as `is_damaged` tells of its answer, is said again, and so is one that is harmless
    /// `twice` whose answer was spoiled or lost; of any other `None` says so.
    pub fn ask_summed(
        &mut self,
        line: &str,
        twice: bool,
        is_damaged: impl Fn(&str) -> bool,
    ) -> Result<Option<String>, Failure> {
        for _ in 0..TRIES {
            self.get_in_step()?;
            self.send(&summed(line))?;
            let mut heard = false;
            // What belongs to no checksum is an answer to the empty line, or was spoiled.
            while let Some(answer) = self.answer()? {
                match unsummed(&answer) {
                    Some(bare) if is_damaged(bare) => heard = true,
                    Some(bare) => return Ok(Some(bare.to_owned())),
                    None if answer.contains('*') => {}
                    None => continue,
                }
                break;
            }
            if !heard && !twice {
                self.get_in_step()?;
                return Ok(None);
            }
        }
        Err(self.silent())
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
        for n in 0..TRIES {
            // An empty line ends what was left of another.
            self.send(if n == 0 { "\r?\r" } else { "?\r" })?;
            self.asked += 1;
            while let Some(answer) = self.line()? {
                if programs::is_wanted(&at, &answer, wanted, &program)?.is_some() {
                    self.greeting = wanted.into();
                    self.asked -= 1;
                    return Ok(answer);
                }
            }
        }
        Err(Failure::new(format!("{at} does not answer")).hint(programs::flash("", program(""))))
    }
}

/// A line with its checksum and its end.
fn summed(line: &str) -> String {
    format!("{line}*{:02X}\r", line.bytes().fold(0, crc))
}

/// An answer without its checksum; `None` without a right one.
fn unsummed(answer: &str) -> Option<&str> {
    let (bare, sum) = answer.rsplit_once('*')?;
    (sum == format!("{:02X}", bare.bytes().fold(0, crc))).then_some(bare)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;

    const GREETING: &str = "stepwright-cycle";

    /// A board that says each line back, the nth after the nth of these times.
    struct Echo {
        delays: Vec<u64>,
        line: Vec<u8>,
        /// When it is free to answer the next line.
        free: Duration,
        answers: VecDeque<(Duration, u8)>,
        now: Duration,
    }

    impl Link for Echo {
        fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
            for byte in bytes {
                if *byte != b'\r' {
                    self.line.push(*byte);
                    continue;
                }
                let line = std::mem::take(&mut self.line);
                let answer = match line.as_slice() {
                    b"" => b"E".to_vec(),
                    b"?" => format!("{GREETING} uno hz=1").into_bytes(),
                    line => line.to_vec(),
                };
                let delay = if self.delays.is_empty() { 0 } else { self.delays.remove(0) };
                self.free = self.free.max(self.now) + Duration::from_millis(delay);
                self.answers.extend(answer.iter().chain(b"\r").map(|byte| (self.free, *byte)));
            }
            Ok(())
        }

        fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
            let due = self.answers.front().map_or(Duration::MAX, |answer| answer.0);
            if due > self.now + limit {
                self.now += limit;
                return Ok(0);
            }
            self.now = self.now.max(due);
            buffer[0] = self.answers.pop_front().expect("one is due").1;
            Ok(1)
        }

        fn now(&self) -> Duration {
            self.now
        }

        fn name(&self) -> String {
            "the board".into()
        }
    }

    fn talk(delays: &[u64]) -> Talk {
        let (line, answers) = (Vec::new(), VecDeque::new());
        let (free, now) = (Duration::ZERO, Duration::ZERO);
        Talk::new(Box::new(Echo { delays: delays.to_vec(), line, free, answers, now }))
    }

    /// However long each takes, and wherever a line was given up.
    #[test]
    fn an_answer_is_never_taken_for_that_to_another_line() {
        for delays in [
            &[0, 0, 700, 0, 0, 3_000, 0, 0][..],
            &[0, 1_700, 900, 0, 0, 0, 5_000, 0, 0],
            &[600; 20],
            &[0, 0, 0, 9_000, 0, 0, 7_000, 600, 600, 600],
            &[2_100, 900, 0, 0, 5_200, 4_100, 0, 0, 4_100],
        ] {
            let mut talk = talk(delays);
            talk.meet(GREETING, |_| "cycles").unwrap();
            let mut answered = 0;
            for n in 0..12 {
                let line = format!("V{n}");
                if let Ok(Some(answer)) = talk.ask(&line, true) {
                    assert_eq!(answer, line, "{delays:?}");
                    answered += 1;
                }
            }
            assert!(answered >= 8, "{delays:?}: {answered}");
        }
    }
}
