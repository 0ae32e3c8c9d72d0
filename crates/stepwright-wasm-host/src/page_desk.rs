//! The link between the page and the keeper: jobs and time in, messages out.

use std::future::poll_fn;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::task::Poll;
use std::time::Duration;

use serde::Serialize;
use stepwright_host::Pipe;
use stepwright_keeper::report::{
    BoardSheet, Controller, Done, LiveMessage, LiveState, PlannedCurve,
};
use stepwright_keeper::{Declined, Hand, Job, JobQueue, KeeperDesk, asked, explain};

/// The only client: a page without a server has its board for itself.
const HAND: Hand = Hand(1);

/// Messages in addition to those of `/api/live`.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum PageMessage {
    /// The board's description.
    Board(BoardSheet),
    /// The answer to a request: its number, its HTTP status and its body.
    Answer {
        id: u32,
        status: u16,
        #[serde(skip_serializing_if = "Option::is_none")]
        done: Option<Done>,
        #[serde(skip_serializing_if = "Option::is_none")]
        declined: Option<Declined>,
    },
    /// Close the wire; open it again later, if the board is only lost.
    Closed { lost: bool },
}

/// An event of the page's wire.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WireEvent {
    /// The wire is open, to the board of this name.
    Open(String),
    /// The wire can't be opened: the name of its board, and the reason.
    Failed(String, String),
    /// The page wants another board.
    Leave,
}

/// Wakes the keeper.
pub enum Wake {
    /// A job, or the time of the next turn.
    Turn(Option<Job>),
    /// The page wants another board.
    Leave,
}

/// The link between the page and the keeper.
pub struct PageDesk(Mutex<Desk>);

struct Desk {
    now: f64,
    jobs: JobQueue,
    wire: Option<WireEvent>,
    /// The line of the present conversation.
    pipe: Pipe,
    /// When to call again if nothing happens.
    until: Option<f64>,
    /// The messages as JSON, one a line.
    messages: String,
    /// Whether the questions to the board are reported too.
    questions: bool,
}

impl Default for PageDesk {
    fn default() -> PageDesk {
        let mut jobs = JobQueue::default();
        jobs.close(Declined::away("no board was met yet"));
        let (wire, until, messages) = (None, None, String::new());
        PageDesk(Mutex::new(Desk {
            now: 0.0,
            jobs,
            wire,
            pipe: Pipe::new(),
            until,
            messages,
            questions: false,
        }))
    }
}

impl Desk {
    fn tell(&mut self, message: &impl Serialize) {
        // No message has a key that is no text, or can fail otherwise.
        self.messages.push_str(&serde_json::to_string(message).unwrap_or_default());
        self.messages.push('\n');
    }
}

impl PageDesk {
    fn desk(&self) -> MutexGuard<'_, Desk> {
        // No change can panic half-way.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the present time, in s.
    pub fn pass(&self, now: f64) {
        let mut desk = self.desk();
        desk.now = now;
        desk.pipe.pass(Duration::try_from_secs_f64(now).unwrap_or_default());
    }

    /// The line of the present conversation.
    pub fn pipe(&self) -> Pipe {
        self.desk().pipe.clone()
    }

    /// A line for a new conversation.
    pub fn new_pipe(&self) -> Pipe {
        let now = self.desk().now;
        self.desk().pipe = Pipe::new();
        self.pass(now);
        self.pipe()
    }

    /// Notes an event of the wire.
    pub fn wire(&self, event: WireEvent) {
        self.desk().wire = Some(event);
    }

    /// Sets whether the questions to the board are reported too.
    pub fn questions(&self, wanted: bool) {
        self.desk().questions = wanted;
    }

    /// Takes a request: `NUMBER NAME`, a line feed, and its body.
    pub fn ask(self: &std::sync::Arc<PageDesk>, request: &str) {
        let (head, body) = request.split_once('\n').unwrap_or((request, "{}"));
        let (id, name) = head.split_once(' ').unwrap_or((head, ""));
        let id = id.parse().unwrap_or_default();
        match asked::wish(name, body, HAND) {
            Ok((wish, waits)) => {
                let desk = self.clone();
                let job = Job::new(wish, waits, move |answer| desk.answer(id, answer));
                // An immediate answer locks the desk again.
                let mut jobs = std::mem::take(&mut self.desk().jobs);
                jobs.put(job);
                self.desk().jobs = jobs;
            }
            Err(why) => self.answer(id, Err(why)),
        }
    }

    fn answer(&self, id: u32, answer: Result<Done, Declined>) {
        let (status, done, declined) = match answer {
            Ok(done) => (200, Some(done), None),
            Err(why) => (why.status(), None, Some(why)),
        };
        self.desk().tell(&PageMessage::Answer { id, status, done, declined });
    }

    /// Accepts no jobs until [`open`](PageDesk::open), for this reason.
    pub fn close(&self, why: Declined) {
        // The answers lock the desk again.
        let mut jobs = std::mem::take(&mut self.desk().jobs);
        jobs.close(why);
        self.desk().jobs = jobs;
    }

    /// Accepts jobs again.
    pub fn open(&self) {
        self.desk().jobs.open();
    }

    /// Asks the page to close the wire.
    pub fn closed(&self, lost: bool) {
        self.desk().tell(&PageMessage::Closed { lost });
    }

    /// Reports a line to the board, and its answer.
    pub fn heard(&self, line: &str, answer: Option<&str>) {
        let mut desk = self.desk();
        let exchange = explain::explain(desk.now, line, answer);
        if !exchange.question || desk.questions {
            desk.tell(&LiveMessage::Line(exchange));
        }
    }

    /// The messages since the last call, one a line.
    pub fn take_messages(&self) -> String {
        std::mem::take(&mut self.desk().messages)
    }

    /// When to call again if nothing happens, in s.
    pub fn until(&self) -> Option<f64> {
        self.desk().until
    }

    /// Waits for an event of the wire.
    pub async fn wire_event(&self) -> WireEvent {
        poll_fn(|_| match self.desk().wire.take() {
            Some(event) => Poll::Ready(event),
            None => Poll::Pending,
        })
        .await
    }

    /// Waits for a job, at most this many seconds.
    pub async fn next(&self, limit: f64) -> Wake {
        let end = self.desk().now + limit;
        poll_fn(|_| {
            let mut desk = self.desk();
            let next = if let Some(WireEvent::Leave) = desk.wire {
                desk.wire = None;
                Wake::Leave
            } else if let Some(job) = desk.jobs.take() {
                Wake::Turn(Some(job))
            } else if desk.now >= end {
                Wake::Turn(None)
            } else {
                desk.until = Some(end);
                return Poll::Pending;
            };
            desk.until = None;
            Poll::Ready(next)
        })
        .await
    }
}

impl KeeperDesk for PageDesk {
    fn time(&self) -> f64 {
        self.desk().now
    }

    fn is_urgent(&self) -> bool {
        self.desk().jobs.is_urgent()
    }

    fn is_there(&self, hand: Hand) -> bool {
        hand == HAND
    }

    fn is_live(&self, hand: Hand) -> bool {
        hand == HAND
    }

    fn describe(&self, sheet: BoardSheet) {
        self.desk().tell(&PageMessage::Board(sheet));
    }

    fn publish(&self, state: LiveState) {
        let mut desk = self.desk();
        let control = Controller { hand: HAND.0, name: "this page".to_owned(), live: true };
        let state = LiveState { time: desk.now, control: Some(control), ..state };
        desk.tell(&LiveMessage::State(state));
    }

    fn note(&self, text: String) {
        let mut desk = self.desk();
        let time = desk.now;
        desk.tell(&LiveMessage::Note { time, text });
    }

    fn plan(&self, curve: PlannedCurve) {
        self.desk().tell(&LiveMessage::Plan(curve));
    }

    fn unplan(&self, axis: u8) {
        let mut desk = self.desk();
        let time = desk.now;
        desk.tell(&LiveMessage::Unplanned { axis, time });
    }
}
