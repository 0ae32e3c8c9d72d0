//! The conversation with a board: a line, its answer, and what to do when the
//! answer does not come.
//!
//! ```text
//!   order ──► Session ──► Master ──► Link ──► … the board
//!                 ◄── Reply ◄──      ◄── bytes, in their time
//! ```
//!
//! A line that got no answer was lost, or its answer was; nobody knows which.
//! So [`Session`] gets in step with the board again, and then
//! - says once more what is harmless twice: questions, A, Z, K, I;
//! - leaves it to the caller to look, after a line of an order.
//!
//! With a board that can `sum` every line has a checksum, and so has its answer: a digit
//! that noise has changed is noticed at either end.

use std::fmt;
use std::io::{self, ErrorKind};
#[cfg(unix)]
use std::path::Path;
use std::time::Duration;

use stepwright_protocol::{
    Ability, AxisId, Command, Info, Master, Refusal, Reply, Selection, Stop,
};

use crate::change::{Change, Travels};
use crate::interrupt;
use crate::link::Link;
#[cfg(unix)]
use crate::link::host::Host;

/// A slave answers within milliseconds.
const PATIENCE: Duration = Duration::from_millis(500);

/// How long a board may take from the opening of its port: one that is reset
/// by it passes its boot loader first.
const BOOT: Duration = Duration::from_millis(4000);

/// How often a line is said before the board counts as silent.
const TRIES: usize = 4;

/// The same of `?`: of the answers that noise spoils most are to it, for they are the
/// longest.
const INFO_TRIES: usize = 8;

/// Between two words to a board that another program is talking to.
const URGE: Duration = Duration::from_millis(100);

/// The first Ctrl-C brakes, the second kills.
const BRAKED_FIRST: usize = 2;

/// The first Ctrl-C kills.
const KILLED_FIRST: usize = 1;

/// How soon a press of Ctrl-C is noticed while waiting.
const SLICE: Duration = Duration::from_millis(20);

/// Why a conversation can't go on.
#[derive(Debug)]
pub enum LinkError {
    /// The line is gone: unplugged, or its other end was closed.
    Gone(io::Error),
    /// The board has stopped answering.
    Silent,
    /// The user wants to kill, and not to wait for this answer.
    Killed,
    /// A signal ends the waiting, where nothing is to be braked.
    Ended,
}

impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // What a port says when it goes is of no use to a reader.
            LinkError::Gone(error) if error.kind() == ErrorKind::UnexpectedEof => {
                f.write_str("the line was closed at its other end")
            }
            LinkError::Gone(error) => write!(f, "the line is gone ({error})"),
            LinkError::Silent => f.write_str("the board does not answer"),
            LinkError::Killed => f.write_str("killed"),
            LinkError::Ended => f.write_str("interrupted"),
        }
    }
}

/// What became of the lines of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Played {
    /// All were answered Y.
    Accepted,
    /// This one was answered E; nothing moves.
    Refused(Command),
    /// This one got no answer.
    Unanswered(Command),
}

/// A conversation with a board.
pub struct Session {
    link: Box<dyn Link>,
    master: Master,
    /// What the board said of itself; `None` if it knows only the Nano slave's lines.
    info: Option<Info>,
    /// Whether our lines have checksums.
    sums: bool,
    /// Which axis F and Z speak of; `None` if we can't be sure.
    selected: Option<Selection>,
    /// This many presses of Ctrl-C end the waiting.
    kill_at: usize,
    /// Other programs that ask the board through us.
    #[cfg(unix)]
    host: Option<Host>,
    /// What others have changed through us, since it was last asked.
    changes: Vec<Change>,
    /// Whether they have changed anything.
    changed: bool,
    /// The travels that were begun here.
    travels: Travels,
}

/// What a guest asks the program that holds the port: where did the travel of my axis begin?
const BEGAN: &[u8] = b"@";

/// A line of a guest, its checksum left out.
#[cfg(unix)]
fn parsed(line: &[u8]) -> Option<Command> {
    Command::parse(line.split(|byte| *byte == b'*').next()?).ok()
}

impl Session {
    /// A conversation that has yet to begin.
    pub fn new(link: Box<dyn Link>) -> Session {
        Session {
            link,
            master: Master::new(),
            info: None,
            sums: false,
            selected: None,
            kill_at: BRAKED_FIRST,
            #[cfg(unix)]
            host: None,
            changes: Vec::new(),
            changed: false,
            travels: Travels::default(),
        }
    }

    /// A line by which another program has changed a motion through us, once.
    pub fn next_change(&mut self) -> Option<Change> {
        (!self.changes.is_empty()).then(|| self.changes.remove(0))
    }

    /// Whether another program has changed a motion through us.
    pub fn was_changed(&self) -> bool {
        self.changed
    }

    /// An axis begins a travel at this position.
    pub fn begins(&mut self, axis: AxisId, from: Option<i64>) {
        self.travels.begins(axis, from);
    }

    /// Where another program has sent the travel of an axis through us.
    pub fn new_target(&self, axis: AxisId) -> Option<i64> {
        self.travels.target(axis)
    }

    /// Where the travel of an axis began, if the program knows that whose guest we are.
    pub fn began(&mut self, axis: AxisId) -> Result<Option<i64>, LinkError> {
        self.select(Selection::One(axis))?;
        let answer = self.say(BEGAN)?;
        Ok(answer.and_then(|answer| answer.parse().ok()))
    }

    /// Lets other stepwrights ask the board on this port, which we hold, while we wait.
    #[cfg(unix)]
    pub fn serve(&mut self, port: &Path) {
        self.host = Host::open(port);
    }

    /// Says what another program wants to be said: one line, then it is our turn again. Our
    /// lease is held by what we say ourselves, not by a crowd that keeps us from saying it.
    #[cfg(unix)]
    fn serve_guest(&mut self) -> Result<(), LinkError> {
        if let Some(asked) = self.host.as_ref().and_then(Host::next) {
            // An axis line is its own selection.
            if let Some(selection) = asked.selection.as_ref().filter(|said| **said != asked.line) {
                self.say(selection)?;
            }
            let axes = match asked.selection.as_deref().map(parsed) {
                Some(Some(Command::Select(axes))) => axes,
                _ => Selection::FIRST,
            };
            if let (BEGAN, Selection::One(axis)) = (asked.line.as_slice(), axes) {
                let from = self.travels.from(axis).map(|from| from.to_string());
                let _ = asked.answer.send(from.or(Some("E".to_owned())));
                return Ok(());
            }
            let answer = self.say(&asked.line)?;
            let accepted = answer.as_ref().is_some_and(|answer| answer.starts_with('Y'));
            if accepted
                && asked.line.first().is_some_and(|letter| b"tmadj@ZK".contains(letter))
                && let Some(command) = parsed(&asked.line)
            {
                let change = self.travels.change(axes, command);
                self.changes.push(change);
                self.changed = true;
            }
            // A guest that is gone needs none.
            let _ = asked.answer.send(answer);
        }
        Ok(())
    }

    #[cfg(not(unix))]
    fn serve_guest(&mut self) -> Result<(), LinkError> {
        Ok(())
    }

    /// Gets in step with the board, and asks what it is.
    pub fn meet(&mut self) -> Result<(), LinkError> {
        let end = self.link.now() + BOOT;
        // A question first: getting in step by force counts as a refused line,
        // and would hide from the user which one was refused before.
        let asked = self.once(Command::Status)?;
        if !matches!(asked, Some(Reply::Ready | Reply::Busy)) {
            while !self.step()? {
                // Nothing moves by us yet, so the first request is enough.
                if self.kill_at == BRAKED_FIRST && interrupt::asked() {
                    return Err(LinkError::Killed);
                }
                self.check_kill()?;
                if self.link.now() >= end {
                    return Err(LinkError::Silent);
                }
            }
        }
        // A slave that knows no `?` may answer E, or nothing.
        for _ in 0..INFO_TRIES {
            match self.once(Command::Info)? {
                Some(Reply::Info(info)) => {
                    self.info = Some(info);
                    self.sums = info.can.is_some_and(|can| can.has(Ability::Sum));
                    self.master.use_sums(self.sums);
                    break;
                }
                Some(_) if self.sums => {}
                Some(_) => break,
                None => self.resync()?,
            }
        }
        Ok(())
    }

    /// Has the first Ctrl-C kill, and any other signal end the waiting, where neither can mean
    /// to brake.
    pub fn kill_at_once(&mut self) {
        self.kill_at = KILLED_FIRST;
    }

    /// The line.
    pub fn link(&mut self) -> &mut dyn Link {
        self.link.as_mut()
    }

    /// How to call the board in a sentence.
    pub fn name(&self) -> String {
        self.link.name()
    }

    /// What the board said of itself when we met.
    pub fn info(&self) -> Option<&Info> {
        self.info.as_ref()
    }

    /// Whether our lines have checksums, and so have their answers.
    pub fn has_sums(&self) -> bool {
        self.sums
    }

    /// The time of the line's clock.
    pub fn now(&self) -> Duration {
        self.link.now()
    }

    /// Puts bytes on the line that are no line of ours.
    pub fn put(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        match self.link.write(bytes) {
            // The answer will not come either; that is when it is dealt with.
            Err(error) if error.kind() == ErrorKind::TimedOut => Ok(()),
            other => other.map_err(LinkError::Gone),
        }
    }

    /// Says a line once. `None` if no answer came.
    pub fn once(&mut self, command: Command) -> Result<Option<Reply>, LinkError> {
        self.master.give_up();
        let Ok(bytes) = self.master.send(command) else { return Ok(None) };
        let bytes: Vec<u8> = bytes.collect();
        #[cfg(unix)]
        if let Some(host) = &self.host {
            host.lease.before(command);
        }
        self.put(&bytes)?;
        let answer = self.answer()?;
        #[cfg(unix)]
        if let (Some(host), Some(reply)) = (&self.host, answer) {
            host.lease.after(command, reply);
        }
        Ok(answer)
    }

    /// Whether the user wants to kill, or to leave, rather than hear more answers.
    fn check_kill(&self) -> Result<(), LinkError> {
        let asked = interrupt::asked();
        match self.kill_at {
            most if interrupt::presses() >= most => Err(LinkError::Killed),
            KILLED_FIRST if asked => Err(LinkError::Ended),
            _ => Ok(()),
        }
    }

    /// Waits for the answer to what was said last.
    fn answer(&mut self) -> Result<Option<Reply>, LinkError> {
        let end = self.link.now() + PATIENCE;
        loop {
            self.check_kill()?;
            let left = end.saturating_sub(self.link.now());
            if left.is_zero() {
                return Ok(None);
            }
            let mut buffer = [0; 256];
            let count = self.link.read(&mut buffer, left.min(SLICE)).map_err(LinkError::Gone)?;
            let mut bytes = buffer.iter().take(count);
            if let Some(reply) = bytes.find_map(|&byte| self.master.receive(byte)) {
                return Ok(Some(reply));
            }
        }
    }

    /// Says a line that need not be one of the protocol, and gives the answer
    /// as it is; `None` if none came.
    pub fn say(&mut self, line: &[u8]) -> Result<Option<String>, LinkError> {
        self.selected = None;
        self.put(&[line, b"\r"].concat())?;
        let end = self.link.now() + PATIENCE;
        let mut answer = Vec::new();
        while self.link.now() < end {
            let mut byte = [0];
            if self.link.read(&mut byte, SLICE).map_err(LinkError::Gone)? == 0 {
                continue;
            }
            match byte[0] {
                b'\n' => {}
                b'\r' if answer.is_empty() => {}
                b'\r' => return Ok(Some(String::from_utf8_lossy(&answer).into_owned())),
                byte => answer.push(byte),
            }
        }
        Ok(None)
    }

    /// One attempt to get in step; true if it worked.
    fn step(&mut self) -> Result<bool, LinkError> {
        self.selected = None;
        let bytes: Vec<u8> = self.master.resync().collect();
        self.put(&bytes)?;
        Ok(self.answer()?.is_some())
    }

    /// Gets in step with the board again. An order that was being programmed
    /// can't be started any more after this; nothing that moves is touched.
    pub fn resync(&mut self) -> Result<(), LinkError> {
        for _ in 0..TRIES {
            if self.step()? {
                return Ok(());
            }
        }
        Err(LinkError::Silent)
    }

    /// Says a line until it is answered: only for one that is harmless twice.
    pub fn ask(&mut self, command: Command) -> Result<Reply, LinkError> {
        for _ in 0..if command == Command::Info { INFO_TRIES } else { TRIES } {
            match self.once(command)? {
                Some(reply) if self.was_damaged(command, reply)? => {}
                Some(reply) => return Ok(reply),
                None => self.resync()?,
            }
        }
        Err(LinkError::Silent)
    }

    /// Whether this is the answer to a line that noise has changed on its way, as a board
    /// that checks sums can tell.
    fn was_damaged(&mut self, command: Command, reply: Reply) -> Result<bool, LinkError> {
        if !self.sums || reply != Reply::No || command == Command::Info {
            return Ok(false);
        }
        Ok(self.why()? == Some(Refusal::Sum))
    }

    /// Says a line that speaks of the selected axis, F or Z, having selected
    /// it. A slave that knows only the Nano slave's lines has nothing to select.
    pub fn ask_of(&mut self, axes: Selection, command: Command) -> Result<Reply, LinkError> {
        for _ in 0..TRIES {
            self.select(axes)?;
            match self.once(command)? {
                Some(reply) if self.was_damaged(command, reply)? => {}
                Some(reply) => return Ok(reply),
                None => self.resync()?,
            }
        }
        Err(LinkError::Silent)
    }

    /// Has the following lines speak of these axes.
    pub fn select(&mut self, axes: Selection) -> Result<(), LinkError> {
        if self.info.is_some() && self.selected != Some(axes) {
            for _ in 0..TRIES {
                // E: the line was damaged, for the axis is one it has.
                if self.ask(Command::Select(axes))? == Reply::Yes {
                    self.selected = Some(axes);
                    return Ok(());
                }
            }
            return Err(LinkError::Silent);
        }
        Ok(())
    }

    /// Whether any of these axes is busy.
    pub fn is_busy(&mut self, axes: Selection) -> Result<bool, LinkError> {
        for _ in 0..TRIES {
            match self.ask_of(axes, Command::Status)? {
                Reply::Ready => return Ok(false),
                Reply::Busy => return Ok(true),
                // E: the line was damaged on its way.
                _ => {}
            }
        }
        Err(LinkError::Silent)
    }

    /// Where the axis is; `None` if the board does not know.
    pub fn position(&mut self, axis: AxisId) -> Result<Option<i64>, LinkError> {
        for _ in 0..TRIES {
            match self.ask(Command::Position(axis))? {
                Reply::Position(steps) => return Ok(Some(steps)),
                // E: not known, or the line was damaged. The board may say
                // which; if not, it says so again.
                _ if self.is_uncertain(axis)? => return Ok(None),
                _ => {}
            }
        }
        Ok(None)
    }

    /// Where an axis is that rests: said twice alike, for a digit may be lost
    /// on its way.
    pub fn rest_position(&mut self, axis: AxisId) -> Result<Option<i64>, LinkError> {
        let mut last = self.position(axis)?;
        for _ in 0..TRIES {
            let again = self.position(axis)?;
            if again == last {
                return Ok(again);
            }
            last = again;
        }
        Err(LinkError::Silent)
    }

    fn is_uncertain(&mut self, axis: AxisId) -> Result<bool, LinkError> {
        let bit = 1u8.wrapping_shl(axis.index() as u32);
        Ok(self.ask_info()?.is_some_and(|info| info.uncertain & bit != 0))
    }

    /// What the board says of itself now; `None` if it knows only document
    /// 004.
    pub fn ask_info(&mut self) -> Result<Option<Info>, LinkError> {
        if self.info.is_some() {
            for _ in 0..TRIES {
                if let Reply::Info(info) = self.ask(Command::Info)? {
                    self.info = Some(info);
                    return Ok(self.info);
                }
            }
        }
        Ok(None)
    }

    /// Why the last line was answered E; `None` if the board can't tell.
    pub fn why(&mut self) -> Result<Option<Refusal>, LinkError> {
        Ok(self.ask_info()?.and_then(|info| info.last))
    }

    /// Why an axis has stopped before the end of its order; `None` if nothing has stopped
    /// it, or the board does not say.
    pub fn stop_of(&mut self, axis: AxisId) -> Option<Stop> {
        self.ask_info().ok()??.stops?.of(axis)
    }

    /// Leaves the line alone for a while.
    pub fn pause(&mut self, time: Duration) -> Result<(), LinkError> {
        let end = self.link.now() + time;
        loop {
            self.check_kill()?;
            self.serve_guest()?;
            let left = end.saturating_sub(self.link.now());
            if left.is_zero() {
                return Ok(());
            }
            // What comes unasked is noise; but a line that is gone shows here.
            self.link.read(&mut [0; 256], left.min(SLICE)).map_err(LinkError::Gone)?;
        }
    }

    /// Says the lines of an order, each after the Y of the one before, and
    /// none again.
    pub fn play(&mut self, lines: impl Iterator<Item = Command>) -> Result<Played, LinkError> {
        for command in lines {
            // PO and A move the selection.
            self.selected = None;
            match self.once(command)? {
                Some(Reply::Yes) => {}
                Some(_) => return Ok(Played::Refused(command)),
                None => return Ok(Played::Unanswered(command)),
            }
        }
        Ok(Played::Accepted)
    }

    /// Says a line that stops a motor before anything else is said, and until
    /// no other program talks to the board, for this time at most: one of ours leaves when its
    /// motor rests. Its answer is theirs to hear meanwhile; ask for it afterwards.
    pub fn urge(&mut self, command: Command, limit: Duration) -> Result<(), LinkError> {
        let begin = self.link.now();
        let bytes: Vec<u8> = command.bytes().collect();
        loop {
            self.put(&bytes)?;
            let waited = self.link.now().saturating_sub(begin);
            if self.link.is_alone() || waited >= limit {
                return Ok(());
            }
            self.check_kill()?;
            self.link.rest(URGE);
        }
    }

    /// Kills all axes, whatever was going on. True if the board said Y.
    pub fn kill(&mut self) -> Result<bool, LinkError> {
        self.kill_at = usize::MAX;
        for _ in 0..TRIES {
            if self.once(Command::Kill)? == Some(Reply::Yes) {
                return Ok(true);
            }
            // Half a line may stand in the slave, and swallow every K.
            self.step()?;
        }
        Ok(false)
    }
}
