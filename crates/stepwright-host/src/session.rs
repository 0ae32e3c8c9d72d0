//! A conversation on a link of this computer, for a thread that blocks.

use std::io::ErrorKind;
use std::pin::pin;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use stepwright_protocol::{AxisId, Command, Info, Order, Refusal, Reply, Selection, Stop};

use crate::change::Change;
use crate::conversation::{Conversation, LinkError, Played};
use crate::guests::Guests;
use crate::link::Link;
use crate::motion::{Action, Ended, NotBegun, Sight, Start};
use crate::pipe::Pipe;
use crate::settings::{ChangedSettings, NoCurves};

/// How often the guard is asked during a wait.
const SLICE: Duration = Duration::from_millis(20);

/// The time between two repeats of a line, while another program talks to the board.
const URGE: Duration = Duration::from_millis(100);

/// What a session is doing while it waits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// Meeting the board: this program has moved nothing yet.
    Meeting,
    /// Waiting for an answer, or for time to pass.
    Asking,
}

/// Returns whether to end the waiting, and why. Called every 20 ms.
pub type Interrupt = Box<dyn FnMut(Activity) -> Option<LinkError>>;

/// A [`Conversation`] and its link. Every method blocks until the answer has come.
pub struct Session {
    /// The first field, so that it is dropped first: a door for guests closes while its port is still held, and
    /// never removes the door of the next holder.
    talk: Conversation,
    link: Box<dyn Link>,
    pipe: Pipe,
    guard: Option<Interrupt>,
    waiting: Activity,
}

/// Methods of a conversation that block.
macro_rules! waited {
    ($($(#[$doc:meta])* $name:ident($($arg:ident: $type:ty),*) -> $out:ty;)*) => {
        $($(#[$doc])*
        pub fn $name(&mut self, $($arg: $type),*) -> Result<$out, LinkError> {
            self.wait(async |talk| talk.$name($($arg),*).await)?
        })*
    };
}

impl Session {
    /// A conversation on this link that has not begun yet.
    pub fn new(link: Box<dyn Link>) -> Session {
        let pipe = Pipe::new();
        let talk = Conversation::new(pipe.clone());
        Session { talk, link, pipe, guard: None, waiting: Activity::Asking }
    }

    /// Sets the guard, which may end the waiting. `None`: nothing ends it from then on.
    pub fn set_guard(&mut self, guard: Option<Interrupt>) {
        self.guard = guard;
    }

    /// Lets other programs ask the board through this session while it waits.
    pub fn serve(&mut self, guests: Box<dyn Guests>) {
        self.talk.serve(guests);
    }

    /// Runs a part of the conversation to its end.
    ///
    /// # Errors
    /// The guard has ended the waiting.
    pub fn wait<T>(
        &mut self,
        part: impl AsyncFnOnce(&mut Conversation) -> T,
    ) -> Result<T, LinkError> {
        let Session { link, pipe, talk, guard, waiting } = self;
        let mut part = pin!(part(talk));
        let mut context = Context::from_waker(Waker::noop());
        let mut buffer = [0; 256];
        loop {
            pipe.pass(link.now());
            let polled = part.as_mut().poll(&mut context);
            let output = pipe.take_output();
            if !output.is_empty() {
                match link.write(&output) {
                    // After a timeout no answer will come either; the part handles that.
                    Err(error) if error.kind() != ErrorKind::TimedOut => pipe.lose(error),
                    _ => {}
                }
            }
            if let Poll::Ready(result) = polled {
                return Ok(result);
            }
            if let Some(why) = guard.as_mut().and_then(|guard| guard(*waiting)) {
                return Err(why);
            }
            let left = pipe.deadline().unwrap_or_default().saturating_sub(link.now());
            if left.is_zero() {
                continue;
            }
            match link.read(&mut buffer, left.min(SLICE)) {
                Ok(count) => pipe.feed(buffer.get(..count).unwrap_or_default()),
                Err(error) => pipe.lose(error),
            }
        }
    }

    waited! {
        /// [`Conversation::once`]
        once(command: Command) -> Option<Reply>;
        /// [`Conversation::say`]
        say(line: &[u8]) -> Option<String>;
        /// [`Conversation::put`]
        put(bytes: &[u8]) -> ();
        /// [`Conversation::resync`]
        resync() -> ();
        /// [`Conversation::ask`]
        ask(command: Command) -> Reply;
        /// [`Conversation::ask_of`]
        ask_of(axes: Selection, command: Command) -> Reply;
        /// [`Conversation::select`]
        select(axes: Selection) -> ();
        /// [`Conversation::is_busy`]
        is_busy(axes: Selection) -> bool;
        /// [`Conversation::position`]
        position(axis: AxisId) -> Option<i64>;
        /// [`Conversation::rest_position`]
        rest_position(axis: AxisId) -> Option<i64>;
        /// [`Conversation::ask_info`]
        ask_info() -> Option<Info>;
        /// [`Conversation::why`]
        why() -> Option<Refusal>;
        /// [`Conversation::began`]
        began(axis: AxisId) -> Option<i64>;
        /// [`Conversation::pause`]
        pause(time: Duration) -> ();
        /// [`Conversation::play`]
        play(lines: &[Command]) -> Played;
        /// [`Conversation::changed_settings`]
        changed_settings() -> ChangedSettings;
        /// [`Conversation::no_curves`]
        no_curves(order: &Order) -> Option<NoCurves>;
        /// [`Conversation::stop`]
        stop(axes: Selection) -> ();
        /// [`Conversation::row`]
        row(row: &str, twice: bool) -> Option<String>;
        /// [`Conversation::about`]
        about() -> String;
    }

    /// [`Conversation::meet`]
    pub fn meet(&mut self) -> Result<(), LinkError> {
        self.waiting = Activity::Meeting;
        let met = self.wait(async |talk| talk.meet().await);
        self.waiting = Activity::Asking;
        met?
    }

    /// [`Conversation::meet_program`]
    pub fn meet_program(&mut self) -> Result<String, LinkError> {
        self.waiting = Activity::Meeting;
        let met = self.wait(async |talk| talk.meet_program().await);
        self.waiting = Activity::Asking;
        met?
    }

    /// [`Conversation::begin_by`]
    pub fn begin_by(
        &mut self,
        axis: AxisId,
        row: &str,
        from: Option<i64>,
    ) -> Result<String, NotBegun> {
        let begun = self.wait(async |talk| talk.begin_by(axis, row, from).await);
        // Whether the motion has begun is unknown.
        begun.map_err(NotBegun::unsure)?
    }

    /// [`Conversation::begin`]
    pub fn begin(
        &mut self,
        axis: AxisId,
        order: &Order,
        lines: &[Command],
        from: Option<i64>,
    ) -> Result<(), NotBegun> {
        let begun = self.wait(async |talk| talk.begin(axis, order, lines, from).await);
        // Whether the motion has begun is unknown.
        begun.map_err(NotBegun::unsure)?
    }

    /// [`Conversation::begin_together`]
    pub fn begin_together(&mut self, starts: &[Start], lines: &[Command]) -> Result<(), NotBegun> {
        let begun = self.wait(async |talk| talk.begin_together(starts, lines).await);
        // Whether the motion has begun is unknown.
        begun.map_err(NotBegun::unsure)?
    }

    /// [`Conversation::watch`]
    pub fn watch(
        &mut self,
        axis: AxisId,
        until: Option<Duration>,
        see: impl FnMut(&mut Conversation, &Sight) -> Action,
    ) -> Result<Sight, LinkError> {
        self.wait(async |talk| talk.watch(axis, until, see).await)?
    }

    /// [`Conversation::conclude`]. After a kill no guard ends it.
    pub fn conclude(&mut self, axis: AxisId, watched: Result<Sight, LinkError>) -> Ended {
        if matches!(watched, Err(LinkError::Killed)) {
            self.guard = None;
        }
        match self.wait(async |talk| talk.conclude(axis, watched).await) {
            Ok(ended) => ended,
            Err(trouble) => Ended {
                end: crate::motion::RestPlace::Uncertain,
                braked: false,
                adrift: Some(crate::motion::Adrift::Lost(trouble)),
            },
        }
    }

    /// [`Conversation::kill`]. No guard ends this call or the calls after it.
    pub fn kill(&mut self) -> Result<bool, LinkError> {
        self.guard = None;
        self.wait(async |talk| talk.kill().await)?
    }

    /// [`Conversation::stop_of`]; `None` also if the question fails.
    pub fn stop_of(&mut self, axis: AxisId) -> Option<Stop> {
        self.wait(async |talk| talk.stop_of(axis).await).ok()?.ok()?
    }

    /// Says a line that stops a motor, before anything else is said, until no other program talks to the board,
    /// for this time at most: a program that runs a motor leaves when the motor rests. Meanwhile the other
    /// program gets the answer; ask for the result afterwards.
    pub fn urge(&mut self, command: Command, limit: Duration) -> Result<(), LinkError> {
        let begin = self.link.now();
        let bytes: Vec<u8> = command.bytes().collect();
        loop {
            self.put(&bytes)?;
            let waited = self.link.now().saturating_sub(begin);
            if self.link.is_alone() || waited >= limit {
                return Ok(());
            }
            let waiting = self.waiting;
            if let Some(why) = self.guard.as_mut().and_then(|guard| guard(waiting)) {
                return Err(why);
            }
            self.link.rest(URGE);
        }
    }

    /// The conversation.
    pub fn talk(&self) -> &Conversation {
        &self.talk
    }

    /// The link.
    pub fn link(&mut self) -> &mut dyn Link {
        self.link.as_mut()
    }

    /// The name of the board in a sentence.
    pub fn name(&self) -> String {
        self.link.name()
    }

    /// The time of the line's clock.
    pub fn now(&self) -> Duration {
        self.link.now()
    }

    /// [`Conversation::info`]
    pub fn info(&self) -> Option<&Info> {
        self.talk.info()
    }

    /// [`Conversation::next_change`]
    pub fn next_change(&mut self) -> Option<Change> {
        self.talk.next_change()
    }

    /// [`Conversation::was_changed`]
    pub fn was_changed(&self) -> bool {
        self.talk.was_changed()
    }

    /// [`Conversation::begins`]
    pub fn begins(&mut self, axis: AxisId, from: Option<i64>) {
        self.talk.begins(axis, from);
    }

    /// [`Conversation::new_target`]
    pub fn new_target(&self, axis: AxisId) -> Option<i64> {
        self.talk.new_target(axis)
    }
}
