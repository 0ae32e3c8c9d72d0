//! The master's half of the line.

use core::fmt;

use crate::command::Command;
use crate::line::Collector;
use crate::reply::Reply;
use crate::sum;
use crate::text::Bytes;

/// The longest answer that a master accepts, in bytes. It leaves room for a field or two that a
/// later version may add to [`Reply::LONGEST`].
const LONGEST: usize = Reply::LONGEST + Reply::LONGEST / 7;

/// Sends one line at a time and recognises its answer.
///
/// It holds no clock and does no I/O. [`send`](Master::send) returns the bytes to put on the line.
/// Pass every byte that comes back to [`receive`](Master::receive), which returns the answer when
/// it is complete. Lines that can't be the answer are noise and skipped: a banner at power-up, a
/// reply with a damaged byte.
///
/// The caller keeps the time. A slave answers within milliseconds. When no answer has come for,
/// say, half a second, the line or its answer was lost, and the master can't know which. Then call
/// [`resync`](Master::resync), and read the position of the axis rather than send the line again.
/// Do so after opening a port too, because the slave may hold half a line.
///
/// ```
/// use stepwright_protocol::{Command, Master, Reply};
/// let mut master = Master::new();
/// let bytes: Vec<u8> = master.send(Command::Status).unwrap().collect();
/// assert_eq!(bytes, b"F\r");
/// assert_eq!(master.receive(b'B'), None);
/// assert_eq!(master.receive(b'\r'), Some(Reply::Busy));
/// ```
#[derive(Clone, Debug)]
pub struct Master {
    line: Collector<LONGEST>,
    awaited: Awaited,
    sums: bool,
}

/// The kind of answer that the master waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Awaited {
    Nothing,
    /// Y or E.
    Verdict,
    /// R or B, or E if the line was damaged on its way.
    Status,
    /// A number or E.
    Position,
    /// The answer to `?`, or E from a slave that knows only the Nano slave's lines.
    Info,
    /// A setting or E.
    Setting,
    /// All settings, or E.
    Settings,
    /// R or B only: the end of a resync.
    Step,
}

impl Awaited {
    fn is(self, reply: &Reply) -> bool {
        match reply {
            Reply::Yes => self == Awaited::Verdict,
            Reply::No => !matches!(self, Awaited::Nothing | Awaited::Step),
            Reply::Ready | Reply::Busy => matches!(self, Awaited::Status | Awaited::Step),
            Reply::Position(_) => self == Awaited::Position,
            Reply::Info(_) => self == Awaited::Info,
            Reply::Setting(_) => self == Awaited::Setting,
            Reply::Settings(_) => self == Awaited::Settings,
        }
    }
}

impl Default for Master {
    fn default() -> Self {
        Master::new()
    }
}

impl Master {
    /// A master that has sent nothing yet.
    pub const fn new() -> Master {
        Master { line: Collector::new(), awaited: Awaited::Nothing, sums: false }
    }

    /// Sends every following line with a checksum, or without one. With checksums, the master
    /// accepts only answers whose checksum is right.
    ///
    /// For a board whose [`Info`](crate::Info) says that it can [`Sum`](crate::Ability::Sum). Other
    /// boards refuse every such line.
    ///
    /// ```
    /// use stepwright_protocol::{Command, Master, Reply};
    /// let mut master = Master::new();
    /// master.use_sums(true);
    /// let bytes: Vec<u8> = master.send(Command::Execute).unwrap().collect();
    /// assert_eq!(bytes, b"E*DC\r");
    /// let answers: Vec<_> = b"Y\rY*88\r".iter().map(|&byte| master.receive(byte)).collect();
    /// assert_eq!(answers.into_iter().flatten().count(), 1);
    /// ```
    pub fn use_sums(&mut self, sums: bool) {
        self.sums = sums;
    }

    /// The bytes of a command, to be put on the line.
    ///
    /// # Errors
    /// [`Waiting`] until the answer to the last line has come.
    pub fn send(&mut self, command: Command) -> Result<Bytes<Command>, Waiting> {
        if self.waiting() {
            return Err(Waiting);
        }
        self.awaited = match command {
            Command::Status => Awaited::Status,
            Command::Position(_) => Awaited::Position,
            Command::Info => Awaited::Info,
            Command::Setting(_) => Awaited::Setting,
            Command::Settings => Awaited::Settings,
            _ => Awaited::Verdict,
        };
        // Bytes that came before, unasked, are not part of the answer.
        self.line.clear();
        Ok(command.bytes().summed(self.sums))
    }

    /// Takes a byte from the line. Returns the answer when it is complete.
    pub fn receive(&mut self, byte: u8) -> Option<Reply> {
        let line = self.line.push(byte)?.ok()?;
        let line = if self.sums { sum::checked(line).ok()? } else { line };
        let reply = Reply::parse(line)?;
        if !self.awaited.is(&reply) {
            return None;
        }
        self.awaited = Awaited::Nothing;
        Some(reply)
    }

    /// Whether an answer is still to come.
    pub fn waiting(&self) -> bool {
        self.awaited != Awaited::Nothing
    }

    /// Stops waiting, so that the next line can be sent at once. Only for K, when the slave is
    /// silent: the master would take a late answer for K's.
    pub fn give_up(&mut self) {
        self.awaited = Awaited::Nothing;
    }

    /// Gets in step again: returns the bytes to put on the line after it has been silent for a
    /// while. [`receive`](Master::receive) then skips all lines up to the slave's status, Ready or
    /// Busy.
    ///
    /// The `#` makes any half line in the slave invalid: a bare CR would complete it, and `G+40` of
    /// `G+4000`, or an `E`, is a valid line. So an order that was being programmed is spoiled; axes
    /// that move continue unchanged.
    pub fn resync(&mut self) -> impl Iterator<Item = u8> + Clone + use<> {
        self.awaited = Awaited::Step;
        self.line.clear();
        let bytes: &[u8] = if self.sums { b"#\rF*D5\r" } else { b"#\rF\r" };
        bytes.iter().copied()
    }
}

/// The answer to the last line has not come yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Waiting;

impl fmt::Display for Waiting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the answer to the last line has yet to come")
    }
}

impl core::error::Error for Waiting {}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::command::tests::any_command;
    use crate::reply::tests::any_reply;
    use crate::{Listed, Setting, Settings, Value};
    use proptest::prelude::*;
    use std::vec::Vec;

    fn receive(master: &mut Master, bytes: &[u8]) -> Vec<Reply> {
        bytes.iter().filter_map(|&byte| master.receive(byte)).collect()
    }

    fn ask(line: &[u8], answer: &[u8]) -> Vec<Reply> {
        let mut master = Master::new();
        let _ = master.send(Command::parse(line).unwrap()).unwrap();
        receive(&mut master, answer)
    }

    #[test]
    fn each_line_takes_its_own_answers() {
        assert_eq!(ask(b"PO", b"Y\r"), [Reply::Yes]);
        assert_eq!(ask(b"PO", b"E\r\n"), [Reply::No]);
        assert_eq!(ask(b"F", b"R\r"), [Reply::Ready]);
        assert_eq!(ask(b"F", b"E\r"), [Reply::No]);
        assert_eq!(ask(b"V1", b"-4000\r"), [Reply::Position(-4000)]);
        assert_eq!(ask(b"V1", b"E\r"), [Reply::No]);
        assert_eq!(ask(b"?", b"E\r"), [Reply::No]);
        assert_eq!(ask(b"$", b"E\r"), [Reply::No]);
        assert_eq!(ask(b"$reset", b"Y\r"), [Reply::Yes]);
        assert_eq!(ask(b"$pulse-us=3", b"Y\r"), [Reply::Yes]);
        let three = Reply::Setting(Value::new(Setting::Pulse, 3).unwrap());
        assert_eq!(ask(b"$pulse-us", b"Y\rpulse-us=3\r"), [three]);
        let all = Reply::Settings(Listed::all(Settings::new()));
        assert_eq!(ask(b"$", &all.bytes().collect::<Vec<u8>>()), [all]);
        assert!(matches!(
            ask(b"?", b"stepwright 0.1 axes=1 max=1 late=0 refused=0 last=none uncertain=0\r")[..],
            [Reply::Info(_)]
        ));
    }

    #[test]
    fn other_lines_are_noise() {
        assert_eq!(ask(b"PO", b"R\rB\r12\r\r\xff\x00Y\rY \rstepper v3 ready\r\nY\r"), [Reply::Yes]);
        assert_eq!(ask(b"F", b"Y\r12\rB\r"), [Reply::Busy]);
        assert_eq!(ask(b"V1", b"Y\rR\r1x\r7\r"), [Reply::Position(7)]);
        assert_eq!(ask(b"K", &[&[b'Y'; 500][..], b"\rY\r"].concat()), [Reply::Yes]);
    }

    #[test]
    fn one_line_at_a_time() {
        let mut master = Master::new();
        assert!(receive(&mut master, b"Y\rE\rR\r1\rhalf").is_empty());
        let _ = master.send(Command::Kill).unwrap();
        assert!(master.waiting());
        assert!(matches!(master.send(Command::Kill), Err(Waiting)));
        assert_eq!(receive(&mut master, b"Y\r"), [Reply::Yes]);
        assert!(receive(&mut master, b"Y\r").is_empty());
        assert!(!master.waiting() && master.send(Command::Kill).is_ok());
        master.give_up();
        assert!(master.send(Command::Kill).is_ok());
    }

    #[test]
    fn a_resync_ends_at_the_status() {
        let mut master = Master::new();
        let _ = master.send(Command::Execute).unwrap();
        let bytes: Vec<u8> = master.resync().collect();
        assert_eq!(bytes, b"#\rF\r");
        assert_eq!(receive(&mut master, b"oise\rY\rE\r17\rB\r"), [Reply::Busy]);
        assert!(!master.waiting());
    }

    proptest! {
        #[test]
        fn nothing_panics_and_one_line_has_one_answer(
            command in any_command(), noise: Vec<u8>, reply in any_reply(), more: Vec<u8>,
        ) {
            let mut master = Master::new();
            let _ = master.send(command).unwrap();
            let answer: Vec<u8> = reply.bytes().collect();
            let heard = receive(&mut master, &[&noise[..], b"\r", &answer, &more].concat());
            prop_assert!(heard.len() <= 1);
        }
    }
}
