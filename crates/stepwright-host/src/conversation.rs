//! The conversation with a board: a line, its answer, and what to do when the
//! answer does not come.
//!
//! ```text
//!   order ──► Conversation ──► Master ──► Pipe ──► … the board
//!                     ◄── Reply ◄──      ◄── bytes, in their time
//! ```
//!
//! A line that got no answer was lost, or its answer was; nobody knows which.
//! So [`Conversation`] gets in step with the board again, and then
//! - says once more what is harmless twice: questions, A, Z, K, I;
//! - leaves it to the caller to look, after a line of an order.
//!
//! With a board that can `sum` every line has a checksum, and so has its answer: a digit
//! that noise has changed is noticed at either end.
//!
//! Every method is a future that waits for the [`Pipe`] alone and may be dropped at any time:
//! whatever is said next gets in step first.

use std::collections::VecDeque;
use std::fmt;
use std::io::{self, ErrorKind};
use std::time::Duration;

use stepwright_protocol::{
    Ability, AxisId, Command, Info, Master, Refusal, Reply, Selection, Stop,
};

use crate::change::{Change, Travels};
use crate::guests::Guests;
use crate::pipe::Pipe;

/// A slave answers within milliseconds.
pub(crate) const PATIENCE: Duration = Duration::from_millis(500);

/// How long a board may take from the opening of its port: one that is reset
/// by it passes its boot loader first.
const BOOT: Duration = Duration::from_millis(4000);

/// How often a line is said before the board counts as silent.
const TRIES: usize = 4;

/// The same of `?`: of the answers that noise spoils most are to it, for they are the
/// longest.
const INFO_TRIES: usize = 8;

/// How many times [`PATIENCE`] a program may be silent before what it owes counts as lost.
const SILENCES: usize = 8;

/// How soon a guest is heard while nothing is said.
const SLICE: Duration = Duration::from_millis(20);

/// Why a conversation can't go on.
#[derive(Debug)]
pub enum LinkError {
    /// The line is gone: unplugged, or its other end was closed.
    Gone(io::Error),
    /// The board has stopped answering.
    Silent,
    /// The caller wants to kill, and not to wait for this answer.
    Killed,
    /// The caller has ended the waiting, where nothing is to be braked.
    Ended,
    /// The board runs another program than the controller: its answer to `?`.
    Program(String),
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
            LinkError::Program(about) => write!(f, "the board runs another program: {about}"),
        }
    }
}

impl std::error::Error for LinkError {}

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
pub struct Conversation {
    pub(crate) pipe: Pipe,
    master: Master,
    /// What the board said of itself; `None` if it knows only the Nano slave's lines.
    info: Option<Info>,
    /// What a program with other features said of itself instead.
    pub(crate) program: Option<String>,
    /// Why such a program has refused its last line: a word, and numbers.
    reason: Option<String>,
    /// Whether our lines have checksums.
    sums: bool,
    /// F's that were said and whose R or B was not heard.
    owed: usize,
    /// A line was said, or a part of it, and its answer was not waited for to the end.
    pub(crate) unheard: bool,
    /// Which axis F and Z speak of; `None` if we can't be sure.
    selected: Option<Selection>,
    /// Other programs that ask the board through us.
    pub(crate) guests: Option<Box<dyn Guests>>,
    /// What others have changed through us, since it was last asked.
    pub(crate) changes: VecDeque<Change>,
    /// Whether they have changed anything.
    pub(crate) changed: bool,
    /// The travels that were begun here.
    pub(crate) travels: Travels,
}

impl Conversation {
    /// A conversation that has yet to begin, on this line.
    pub fn new(pipe: Pipe) -> Conversation {
        Conversation {
            pipe,
            master: Master::new(),
            info: None,
            program: None,
            reason: None,
            sums: false,
            owed: 0,
            unheard: false,
            selected: None,
            guests: None,
            changes: VecDeque::new(),
            changed: false,
            travels: Travels::default(),
        }
    }

    /// Lets other programs ask the board through this conversation, while it waits.
    pub fn serve(&mut self, guests: Box<dyn Guests>) {
        self.guests = Some(guests);
    }

    /// A line by which another program has changed a motion through us, once. The last 64 are kept.
    pub fn next_change(&mut self) -> Option<Change> {
        self.changes.pop_front()
    }

    /// Whether another program has changed a motion through us.
    pub fn was_changed(&self) -> bool {
        self.changed
    }

    /// An axis begins a travel at this position.
    pub fn begins(&mut self, axis: AxisId, from: Option<i64>) {
        self.travels.begins(axis, from);
    }

    /// A line that we have said, and that was taken, has changed the travels of these axes.
    pub(crate) fn has_changed(&mut self, axes: Selection, line: Command) {
        self.travels.change(axes, line);
    }

    /// Where the travel of an axis was sent on its way, by us or by another program through us.
    pub fn new_target(&self, axis: AxisId) -> Option<i64> {
        self.travels.target(axis)
    }

    /// What the board said of itself last; `None` if it knows only the Nano slave's lines.
    pub fn info(&self) -> Option<&Info> {
        self.info.as_ref()
    }

    /// Whether our lines have checksums, and so have their answers.
    pub fn has_sums(&self) -> bool {
        self.sums
    }

    /// The time of the line's clock.
    pub fn now(&self) -> Duration {
        self.pipe.now()
    }

    /// Gets in step with the board, and asks what it is.
    ///
    /// # Errors
    /// [`LinkError::Silent`] after 4 s: no board of ours, or another baud rate;
    /// [`LinkError::Program`].
    pub async fn meet(&mut self) -> Result<(), LinkError> {
        self.greet().await?;
        self.program.clone().map_or(Ok(()), |about| Err(LinkError::Program(about)))
    }

    /// The same, whichever program the board runs.
    pub(crate) async fn greet(&mut self) -> Result<(), LinkError> {
        let end = self.now() + BOOT;
        // A question first: getting in step by force counts as a refused line,
        // and would hide from the user which one was refused before.
        let asked = self.once(Command::Status).await?;
        if !matches!(asked, Some(Reply::Ready | Reply::Busy)) {
            while !self.step().await? {
                if self.now() >= end {
                    return Err(LinkError::Silent);
                }
            }
        }
        // A slave that knows no `?` may answer E, or nothing.
        for _ in 0..INFO_TRIES {
            match self.once(Command::Info).await? {
                Some(Reply::Info(info)) => {
                    self.info = Some(info);
                    self.sums = info.can.is_some_and(|can| can.has(Ability::Sum));
                    self.master.use_sums(self.sums);
                    break;
                }
                Some(_) if self.sums => {}
                Some(_) => break,
                None if self.program.is_some() => {
                    self.sums = true;
                    self.master.use_sums(true);
                    break;
                }
                None => self.resync().await?,
            }
        }
        Ok(())
    }

    /// Puts bytes on the line that are no line of ours.
    pub async fn put(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.pipe.write(bytes.iter().copied());
        Ok(())
    }

    /// Says a line once. `None` if no answer came.
    pub async fn once(&mut self, command: Command) -> Result<Option<Reply>, LinkError> {
        self.in_step().await?;
        self.master.give_up();
        let Ok(bytes) = self.master.send(command) else { return Ok(None) };
        if let Some(guests) = &self.guests {
            guests.before(command);
        }
        self.pipe.write(bytes);
        self.owed += usize::from(command == Command::Status);
        let answer = self.answer().await?;
        self.unheard = false;
        if let (Some(guests), Some(reply)) = (&self.guests, answer) {
            guests.after(command, reply);
        }
        Ok(answer)
    }

    /// A line is about to be said: where a future was dropped before the answer to the last one,
    /// that is waited for first, or it would be taken for this one's.
    pub(crate) async fn in_step(&mut self) -> Result<(), LinkError> {
        if self.unheard {
            self.catch_up().await?;
        } else if self.program.is_none() {
            self.owed = 0;
        }
        self.unheard = true;
        Ok(())
    }

    /// Waits for the answer to what was said last. That of another program to `?` ends the
    /// waiting, too.
    async fn answer(&mut self) -> Result<Option<Reply>, LinkError> {
        let (end, mut line) = (self.now() + PATIENCE, Vec::new());
        while let Some(byte) = self.pipe.byte_until(end).await? {
            let reply = self.master.receive(byte);
            match byte {
                b'\r' => {
                    let text = String::from_utf8_lossy(&line).into_owned();
                    line.clear();
                    let bare = text.split('*').next().unwrap_or_default();
                    self.hear(bare);
                    if bare.starts_with("stepwright-") {
                        self.program = Some(bare.to_owned());
                        self.master.give_up();
                        return Ok(None);
                    }
                    self.reason = bare.strip_prefix("E ").map(str::to_owned);
                }
                b'\n' => {}
                byte => line.push(byte),
            }
            if let Some(reply) = reply {
                self.pipe.forget_incoming();
                return Ok(Some(reply));
            }
        }
        Ok(None)
    }

    /// Says a line that need not be one of the protocol, and gives the answer
    /// as it is; `None` if none came.
    pub async fn say(&mut self, line: &[u8]) -> Result<Option<String>, LinkError> {
        self.in_step().await?;
        self.selected = None;
        self.pipe.write(line.iter().copied().chain([b'\r']));
        let answer = self.line().await?;
        self.unheard = false;
        Ok(answer)
    }

    /// This line has come from the board, without its checksum: true if it answers an F.
    pub(crate) fn hear(&mut self, bare: &str) -> bool {
        let status = matches!(bare, "R" | "B");
        self.owed = self.owed.saturating_sub(status.into());
        status
    }

    /// Says F behind what ends half a line.
    fn say_step(&mut self) {
        (self.selected, self.unheard) = (None, true);
        self.pipe.write(self.master.resync());
        self.owed += 1;
    }

    /// One attempt to get in step; true if it worked.
    async fn step(&mut self) -> Result<bool, LinkError> {
        self.say_step();
        let answer = self.answer().await?;
        self.unheard = false;
        Ok(answer.is_some())
    }

    /// Gets in step with a board, however late it answers: once each F that was said has its
    /// answer, none to an earlier line is to come. Where some do not come they were lost.
    async fn catch_up(&mut self) -> Result<(), LinkError> {
        let (mut heard, mut silent) = (false, 0);
        self.say_step();
        while silent < self.silences(heard) {
            match self.line().await? {
                Some(line) => {
                    let bare = line.split('*').next().unwrap_or_default();
                    if self.hear(bare) {
                        (heard, silent) = (true, 0);
                        if self.owed == 0 {
                            self.unheard = false;
                            return Ok(());
                        }
                    }
                }
                None => {
                    silent += 1;
                    if !heard {
                        self.say_step();
                    }
                }
            }
        }
        (self.owed, self.unheard) = (0, false);
        if heard { Ok(()) } else { Err(LinkError::Silent) }
    }

    /// How long a board may be silent before what it owes counts as lost: one that has `heard` us
    /// answers within milliseconds, but for a program.
    fn silences(&self, heard: bool) -> usize {
        match (&self.program, heard) {
            (Some(_), _) => SILENCES,
            (None, true) => 1,
            (None, false) => TRIES,
        }
    }

    /// The next line from the board, without its end; `None` if none comes for a while. CR ends a line;
    /// an LF is skipped, and so is an empty line.
    pub(crate) async fn line(&mut self) -> Result<Option<String>, LinkError> {
        let (end, mut line) = (self.now() + PATIENCE, Vec::new());
        while let Some(byte) = self.pipe.byte_until(end).await? {
            match byte {
                b'\r' if !line.is_empty() => {
                    return Ok(Some(String::from_utf8_lossy(&line).into_owned()));
                }
                b'\r' | b'\n' => {}
                byte => line.push(byte),
            }
        }
        Ok(None)
    }

    /// Gets in step with the board again. An order that was being programmed
    /// can't be started any more after this; nothing that moves is touched.
    pub async fn resync(&mut self) -> Result<(), LinkError> {
        if self.program.is_some() {
            return self.catch_up().await;
        }
        for _ in 0..TRIES {
            if self.step().await? {
                return Ok(());
            }
        }
        Err(LinkError::Silent)
    }

    /// Says a line until it is answered: only for one that is harmless twice.
    pub async fn ask(&mut self, command: Command) -> Result<Reply, LinkError> {
        for _ in 0..if command == Command::Info { INFO_TRIES } else { TRIES } {
            match self.once(command).await? {
                Some(reply) if self.was_damaged(command, reply).await? => {}
                Some(reply) => return Ok(reply),
                None => self.resync().await?,
            }
        }
        Err(LinkError::Silent)
    }

    /// Whether this is the answer to a line that noise has changed on its way, as a board
    /// that checks sums can tell.
    async fn was_damaged(&mut self, command: Command, reply: Reply) -> Result<bool, LinkError> {
        if !self.sums || reply != Reply::No || command == Command::Info {
            return Ok(false);
        }
        // (Boxed: to ask why is to ask.)
        Ok(Box::pin(self.why()).await? == Some(Refusal::Sum))
    }

    /// Says a line that speaks of the selected axis, F or Z, having selected
    /// it. A slave that knows only the Nano slave's lines has nothing to select.
    pub async fn ask_of(&mut self, axes: Selection, command: Command) -> Result<Reply, LinkError> {
        for _ in 0..TRIES {
            self.select(axes).await?;
            match self.once(command).await? {
                Some(reply) if self.was_damaged(command, reply).await? => {}
                Some(reply) => return Ok(reply),
                None => self.resync().await?,
            }
        }
        Err(LinkError::Silent)
    }

    /// Has the following lines speak of these axes.
    pub async fn select(&mut self, axes: Selection) -> Result<(), LinkError> {
        if self.info.is_none() || self.selected == Some(axes) {
            return Ok(());
        }
        // The line may be taken, and this future dropped before its answer.
        self.selected = None;
        for _ in 0..TRIES {
            // E: the line was damaged, for the axis is one it has.
            if self.ask(Command::Select(axes)).await? == Reply::Yes {
                self.selected = Some(axes);
                return Ok(());
            }
        }
        Err(LinkError::Silent)
    }

    /// Whether any of these axes is busy.
    pub async fn is_busy(&mut self, axes: Selection) -> Result<bool, LinkError> {
        for _ in 0..TRIES {
            match self.ask_of(axes, Command::Status).await? {
                Reply::Ready => return Ok(false),
                Reply::Busy => return Ok(true),
                // E: the line was damaged on its way.
                _ => {}
            }
        }
        Err(LinkError::Silent)
    }

    /// Where the axis is, in steps; `None` if the board does not know.
    pub async fn position(&mut self, axis: AxisId) -> Result<Option<i64>, LinkError> {
        for _ in 0..TRIES {
            match self.ask(Command::Position(axis)).await? {
                Reply::Position(steps) => return Ok(Some(steps)),
                // E: not known, or the line was damaged. The board may say
                // which: if it is certain of the axis, it says so again.
                _ if self.is_uncertain(axis).await? => return Ok(None),
                _ => {}
            }
        }
        Ok(None)
    }

    /// Where an axis is that rests: said twice alike, for a digit may be lost
    /// on its way.
    pub async fn rest_position(&mut self, axis: AxisId) -> Result<Option<i64>, LinkError> {
        let mut last = self.position(axis).await?;
        for _ in 0..TRIES {
            let again = self.position(axis).await?;
            if again == last {
                return Ok(again);
            }
            last = again;
        }
        Err(LinkError::Silent)
    }

    async fn is_uncertain(&mut self, axis: AxisId) -> Result<bool, LinkError> {
        if self.program.is_some() {
            return Ok(self.reason.as_deref() == Some(Refusal::Uncertain.name()));
        }
        let bit = 1u8.wrapping_shl(axis.index() as u32);
        Ok(self.ask_info().await?.is_some_and(|info| info.uncertain & bit != 0))
    }

    /// What the board says of itself now; `None` if it knows only the Nano slave's lines.
    pub async fn ask_info(&mut self) -> Result<Option<Info>, LinkError> {
        if self.info.is_some() {
            for _ in 0..TRIES {
                if let Reply::Info(info) = self.ask(Command::Info).await? {
                    self.info = Some(info);
                    return Ok(self.info);
                }
            }
        }
        Ok(None)
    }

    /// Why the last line was answered E; `None` if the board can't tell.
    pub async fn why(&mut self) -> Result<Option<Refusal>, LinkError> {
        if self.program.is_some() {
            let word = self.reason.as_ref().and_then(|reason| reason.split(' ').next());
            return Ok(word.map(|word| Refusal::named(word.as_bytes())));
        }
        Ok(self.ask_info().await?.and_then(|info| info.last))
    }

    /// Why an axis has stopped before the end of its order; `None` if nothing has stopped
    /// it, or the board does not say.
    pub async fn stop_of(&mut self, axis: AxisId) -> Result<Option<Stop>, LinkError> {
        Ok(self.ask_info().await?.and_then(|info| info.stops?.of(axis)))
    }

    /// Leaves the line alone for a while, but for what guests want to be said.
    pub async fn pause(&mut self, time: Duration) -> Result<(), LinkError> {
        let end = self.now() + time;
        loop {
            self.serve_guest().await?;
            let left = end.saturating_sub(self.now());
            if left.is_zero() {
                return Ok(());
            }
            let slice = if self.guests.is_some() { left.min(SLICE) } else { left };
            self.pipe.rest_until(self.now() + slice).await?;
        }
    }

    /// Says the lines of an order, each after the Y of the one before, and
    /// none again.
    pub async fn play(&mut self, lines: &[Command]) -> Result<Played, LinkError> {
        for &command in lines {
            // PO and A move the selection.
            self.selected = None;
            match self.once(command).await? {
                Some(Reply::Yes) => {}
                Some(_) => return Ok(Played::Refused(command)),
                None => return Ok(Played::Unanswered(command)),
            }
        }
        Ok(Played::Accepted)
    }

    /// Kills all axes, whatever was going on. True if the board said Y.
    pub async fn kill(&mut self) -> Result<bool, LinkError> {
        if self.unheard {
            // At once, behind what ends half a line; and again, for its answer can't be told.
            self.pipe.write(*b"#\rK\r");
        }
        for _ in 0..TRIES {
            match self.once(Command::Kill).await {
                Ok(Some(Reply::Yes)) => return Ok(true),
                Ok(_) | Err(LinkError::Silent) => {}
                Err(trouble) => return Err(trouble),
            }
            // Half a line may stand in the slave, and swallow every K.
            self.step().await?;
        }
        Ok(false)
    }
}
