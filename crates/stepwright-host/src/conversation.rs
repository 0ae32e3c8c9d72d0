//! The conversation with a board: a line, its answer, and what to do when no answer comes.
//!
//! ```text
//!   order ──► Conversation ──► Master ──► Pipe ──► … the board
//!                     ◄── Reply ◄──      ◄── bytes, in their time
//! ```
//!
//! If no answer comes, either the line or its answer was lost, and nobody can tell which. [`Conversation`] then
//! gets in step with the board again, and
//! - repeats lines that are harmless twice: questions, A, Z, K, I;
//! - leaves it to the caller to check the axes after a line of an order.
//!
//! With a board that can `sum`, every line and every answer has a checksum: either end notices a digit that
//! noise has changed.
//!
//! Every method is a future that waits for the [`Pipe`] alone, and may be dropped at any time: the next line
//! first gets in step.

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

/// How long an answer is waited for. A controller answers within milliseconds.
pub(crate) const PATIENCE: Duration = Duration::from_millis(500);

/// How long a board may take from the opening of its port. A board that the opening resets first runs its boot
/// loader.
const BOOT: Duration = Duration::from_millis(4000);

/// How often a line is said before the board counts as silent.
const TRIES: usize = 4;

/// The same for `?`: noise spoils its answer most often, as that is the longest.
const INFO_TRIES: usize = 8;

/// How many times [`PATIENCE`] a program may be silent before its missing answers count as lost.
const SILENCES: usize = 8;

/// The time between two looks for a guest's line while the line is idle.
const SLICE: Duration = Duration::from_millis(20);

/// Why a conversation can't go on.
#[derive(Debug)]
pub enum LinkError {
    /// The line is gone: unplugged, or its other end was closed.
    Gone(io::Error),
    /// The board has stopped answering.
    Silent,
    /// The caller wants to kill instead of waiting for this answer.
    Killed,
    /// The caller has ended the waiting, and nothing needs braking.
    Ended,
    /// The board runs another program than the controller: its answer to `?`.
    Program(String),
}

impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            // A port's own message for this case does not help a user.
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

/// The result of saying the lines of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Played {
    /// All lines were answered Y.
    Accepted,
    /// This line was answered E; nothing moves.
    Refused(Command),
    /// This line got no answer.
    Unanswered(Command),
}

/// A conversation with a board.
pub struct Conversation {
    pub(crate) pipe: Pipe,
    master: Master,
    /// The board's last answer to `?`; `None` if it knows only the lines of the Nano slave.
    info: Option<Info>,
    /// The answer to `?` of a program with other features.
    pub(crate) program: Option<String>,
    /// The reason why such a program refused its last line: a word and numbers.
    reason: Option<String>,
    /// Whether lines have checksums.
    sums: bool,
    /// The number of F lines whose R or B has not come.
    owed: usize,
    /// A line was said, at least in part, and its answer was not waited for to the end.
    pub(crate) unheard: bool,
    /// The selection that F and Z apply to; `None` if it is not certain.
    selected: Option<Selection>,
    /// Other programs that ask the board through this one.
    pub(crate) guests: Option<Box<dyn Guests>>,
    /// Changes that guests have made since the last question for them.
    pub(crate) changes: VecDeque<Change>,
    /// Whether guests have changed anything.
    pub(crate) changed: bool,
    /// The travels that this program began.
    pub(crate) travels: Travels,
}

impl Conversation {
    /// A conversation on this line that has not begun yet.
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

    /// Lets other programs ask the board through this conversation while it waits.
    pub fn serve(&mut self, guests: Box<dyn Guests>) {
        self.guests = Some(guests);
    }

    /// The next line by which another program has changed a motion through this one; returned once. The last 64
    /// are kept.
    pub fn next_change(&mut self) -> Option<Change> {
        self.changes.pop_front()
    }

    /// Whether another program has changed a motion through this one.
    pub fn was_changed(&self) -> bool {
        self.changed
    }

    /// Notes that an axis begins a travel at this position.
    pub fn begins(&mut self, axis: AxisId, from: Option<i64>) {
        self.travels.begins(axis, from);
    }

    /// Notes that the board has taken a line of ours which changes the travels of these axes.
    pub(crate) fn has_changed(&mut self, axes: Selection, line: Command) {
        self.travels.change(axes, line);
    }

    /// The new target of an axis' travel, from this program or from another one through it.
    pub fn new_target(&self, axis: AxisId) -> Option<i64> {
        self.travels.target(axis)
    }

    /// The board's last answer to `?`; `None` if it knows only the lines of the Nano slave.
    pub fn info(&self) -> Option<&Info> {
        self.info.as_ref()
    }

    /// Whether lines and answers have checksums.
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
    /// [`LinkError::Silent`] after 4 s: no Stepwright board, or another baud rate; [`LinkError::Program`].
    pub async fn meet(&mut self) -> Result<(), LinkError> {
        self.greet().await?;
        self.program.clone().map_or(Ok(()), |about| Err(LinkError::Program(about)))
    }

    /// Gets in step with a board, whichever program it runs.
    pub(crate) async fn greet(&mut self) -> Result<(), LinkError> {
        let end = self.now() + BOOT;
        // F first: getting in step by force counts as a refused line, and would overwrite the reason of the
        // refusal before, which a user may ask for.
        let asked = self.once(Command::Status).await?;
        if !matches!(asked, Some(Reply::Ready | Reply::Busy)) {
            while !self.step().await? {
                if self.now() >= end {
                    return Err(LinkError::Silent);
                }
            }
        }
        // A controller that does not know `?` may answer E, or nothing. Without a checksum noise may have changed
        // an answer: it counts only once it is repeated.
        let mut before = None;
        for _ in 0..INFO_TRIES {
            let answer = self.once(Command::Info).await?;
            let sure = self.sums || before == answer;
            before = answer;
            match answer {
                Some(Reply::Info(info)) => {
                    self.info = Some(info);
                    if sure {
                        break;
                    }
                    self.sums = info.can.is_some_and(|can| can.has(Ability::Sum));
                    self.master.use_sums(self.sums);
                }
                Some(_) if self.sums || !sure => {}
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

    /// Writes bytes that are no line of the protocol.
    pub async fn put(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        self.pipe.write(bytes.iter().copied());
        Ok(())
    }

    /// Says a line once. `None` if no answer comes.
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
        if answer.is_none() {
            // A guest may be connected again, with another selection.
            self.selected = None;
        }
        if let (Command::Zero(axis), Some(Reply::Yes)) = (command, answer) {
            // Its ends counted from another 0.
            self.begins(axis, None);
        }
        if let (Some(guests), Some(reply)) = (&self.guests, answer) {
            guests.after(command, reply);
        }
        Ok(answer)
    }

    /// Prepares for a new line. If a future was dropped before the answer to the last line, that answer is
    /// waited for first: otherwise it would be taken for the answer to the new line.
    pub(crate) async fn in_step(&mut self) -> Result<(), LinkError> {
        if self.unheard {
            self.catch_up().await?;
        } else if self.program.is_none() {
            self.owed = 0;
        }
        self.unheard = true;
        Ok(())
    }

    /// Waits for the answer to the last line. The answer of another program to `?` also ends the waiting.
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

    /// Says a line that need not be one of the protocol, and returns the answer unchanged; `None` if none
    /// comes.
    pub async fn say(&mut self, line: &[u8]) -> Result<Option<String>, LinkError> {
        self.in_step().await?;
        self.selected = None;
        self.pipe.write(line.iter().copied().chain([b'\r']));
        let answer = self.line().await?;
        self.unheard = false;
        Ok(answer)
    }

    /// Handles a line from the board, without its checksum. True if it answers an F.
    pub(crate) fn hear(&mut self, bare: &str) -> bool {
        let status = matches!(bare, "R" | "B");
        self.owed = self.owed.saturating_sub(status.into());
        status
    }

    /// Says F after bytes that end an incomplete line.
    fn say_step(&mut self) {
        (self.selected, self.unheard) = (None, true);
        self.pipe.write(self.master.resync());
        self.owed += 1;
    }

    /// Tries once to get in step; true if that worked.
    async fn step(&mut self) -> Result<bool, LinkError> {
        self.say_step();
        let answer = self.answer().await?;
        self.unheard = false;
        Ok(answer.is_some())
    }

    /// Gets in step with a board, however late it answers: once each F has its answer, no answer to an earlier
    /// line is still to come. Answers that do not come count as lost.
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

    /// How many [`PATIENCE`] a board may be silent before its missing answers count as lost. A board that has
    /// `heard` us answers within milliseconds, unless it runs another program.
    fn silences(&self, heard: bool) -> usize {
        match (&self.program, heard) {
            (Some(_), _) => SILENCES,
            (None, true) => 1,
            (None, false) => TRIES,
        }
    }

    /// The next line from the board, without its end; `None` if none comes within [`PATIENCE`]. CR ends a line.
    /// LF and empty lines are skipped.
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

    /// Gets in step with the board again. An order that was being programmed can't be started after that;
    /// moving axes are not affected.
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

    /// Says a line until it is answered. Only for a line that is harmless twice.
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

    /// Whether this answer refuses a line that noise changed on its way. Only a board that checks sums can
    /// tell.
    async fn was_damaged(&mut self, command: Command, reply: Reply) -> Result<bool, LinkError> {
        if !self.sums || reply != Reply::No || command == Command::Info {
            return Ok(false);
        }
        // Boxed, as `why` calls `ask`.
        Ok(Box::pin(self.why()).await? == Some(Refusal::Sum))
    }

    /// Selects these axes, and says a line that applies to the selection, such as F or Z. A board that knows
    /// only the lines of the Nano slave has no selection.
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

    /// Makes the following lines apply to these axes.
    pub async fn select(&mut self, axes: Selection) -> Result<(), LinkError> {
        if self.info.is_none() || self.selected == Some(axes) {
            return Ok(());
        }
        // The board may take the line and this future be dropped before the answer.
        self.selected = None;
        for _ in 0..TRIES {
            // E: the line was damaged, as the board has this axis.
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

    /// The position of the axis, in steps; `None` if the board does not know it.
    pub async fn position(&mut self, axis: AxisId) -> Result<Option<i64>, LinkError> {
        for _ in 0..TRIES {
            match self.ask(Command::Position(axis)).await? {
                Reply::Position(steps) => return Ok(Some(steps)),
                // E: the position is unknown, or the line was damaged. If the board's `?` says that the
                // position is known, ask again.
                _ if self.is_uncertain(axis).await? => return Ok(None),
                _ => {}
            }
        }
        Ok(None)
    }

    /// The position of an axis at rest. Two equal answers are required, as noise may lose a digit.
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

    /// Asks the board what it is now; `None` if it knows only the lines of the Nano slave.
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

    /// Says nothing for this time, except for the lines of guests.
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

    /// Says the lines of an order, each after the Y of the line before, and repeats none.
    pub async fn play(&mut self, lines: &[Command]) -> Result<Played, LinkError> {
        for &command in lines {
            // PO and A change the selection.
            self.selected = None;
            match self.once(command).await? {
                Some(Reply::Yes) => {}
                Some(_) => return Ok(Played::Refused(command)),
                None => return Ok(Played::Unanswered(command)),
            }
        }
        Ok(Played::Accepted)
    }

    /// Kills all axes, in any state of the conversation. True if the board answered Y.
    pub async fn kill(&mut self) -> Result<bool, LinkError> {
        if self.unheard {
            // At once, after bytes that end an incomplete line. The loop repeats K, as the answer to this one
            // can't be told from others.
            self.pipe.write(*b"#\rK\r");
        }
        for _ in 0..TRIES {
            match self.once(Command::Kill).await {
                Ok(Some(Reply::Yes)) => return Ok(true),
                Ok(_) | Err(LinkError::Silent) => {}
                Err(trouble) => return Err(trouble),
            }
            // An incomplete line in the board could swallow every K.
            self.step().await?;
        }
        Ok(false)
    }
}
