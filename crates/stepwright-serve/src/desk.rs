//! The link between the server and the board's thread.
//!
//! ```text
//!   request ─► Wish ─► ServeDesk (waiting orders) ─► the board's thread
//!   pages   ◄─ JSON ◄─ ServeDesk (state, lines)   ◄─ the board's thread
//! ```

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use axum::extract::ws::Utf8Bytes;
use stepwright_protocol::Selection;
use tokio::sync::{Notify, broadcast, oneshot, watch};

use crate::calc::Calculators;
use crate::control::ControlLease;
use crate::path::{PathDrawing, PathFile, PathReader};
use stepwright_keeper::Wish;
use stepwright_keeper::explain;
use stepwright_keeper::report::{
    BoardSheet, Controller, Done, LiveMessage, LiveState, PathReport, PlannedCurve,
};
use stepwright_keeper::scope::{ScopeRecord, ScopeSource};
use stepwright_keeper::{Declined, Hand, Job, JobQueue, KeeperDesk};

/// How many lines a page may be behind before it misses some.
const BEHIND: usize = 256;

/// A message for all pages.
#[derive(Clone, Debug)]
pub(crate) struct Told {
    pub text: Utf8Bytes,
    /// Whether it is a question, which goes only to pages that want questions too.
    pub question: bool,
}

/// The state shared by both sides.
pub struct ServeDesk {
    begun: Instant,
    waiting: Mutex<JobQueue>,
    come: Condvar,
    control: Mutex<ControlLease>,
    sheet: Mutex<BoardSheet>,
    scope: Mutex<Option<Arc<dyn ScopeSource>>>,
    calculators: OnceLock<Calculators>,
    paths: OnceLock<Arc<dyn PathReader>>,
    path: Mutex<Option<PathReport>>,
    /// Locked while a path is drawn. Keeps the last drawing, which is often run next.
    pub(crate) drawing: Arc<tokio::sync::Mutex<Option<(PathFile, PathDrawing)>>>,
    /// Locked while a record of the pins is read, or made a file.
    pub(crate) making: Arc<tokio::sync::Mutex<()>>,
    /// The number of stops and kills of all axes so far.
    stops: AtomicUsize,
    state: watch::Sender<(LiveState, Utf8Bytes)>,
    told: broadcast::Sender<Told>,
    /// The number of pages that want questions too.
    pub(crate) listeners: AtomicUsize,
    gone: Notify,
    ended: AtomicBool,
}

/// [Ends](ServeDesk::end) a desk when it is dropped: in the board's thread, also by a panic.
pub struct DeskEnd(pub Arc<ServeDesk>);

impl Drop for DeskEnd {
    fn drop(&mut self) {
        self.0.end();
    }
}

/// Locks in spite of a panic: no change can panic half-way.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Default for ServeDesk {
    fn default() -> ServeDesk {
        ServeDesk {
            begun: Instant::now(),
            waiting: Mutex::default(),
            come: Condvar::new(),
            control: Mutex::default(),
            sheet: Mutex::default(),
            scope: Mutex::default(),
            calculators: OnceLock::new(),
            paths: OnceLock::new(),
            path: Mutex::default(),
            drawing: Arc::default(),
            making: Arc::default(),
            stops: AtomicUsize::new(0),
            state: watch::Sender::default(),
            told: broadcast::Sender::new(BEHIND),
            listeners: AtomicUsize::new(0),
            gone: Notify::new(),
            ended: AtomicBool::new(false),
        }
    }
}

/// The side of the board's thread.
impl ServeDesk {
    /// Waits for a job, at most `limit`.
    pub fn next(&self, limit: Duration) -> Option<Job> {
        let waiting = lock(&self.waiting);
        let empty = |waiting: &mut JobQueue| waiting.is_empty();
        let waited = self.come.wait_timeout_while(waiting, limit, empty);
        waited.unwrap_or_else(PoisonError::into_inner).0.take()
    }

    /// Sets the source of the edges of the board's pins.
    pub fn probe(&self, source: Arc<dyn ScopeSource>) {
        *lock(&self.scope) = Some(source);
    }

    /// Sets the calculators; once.
    pub fn calculate_by(&self, calculators: Calculators) {
        let _ = self.calculators.set(calculators);
    }

    /// Sets the reader of paths; once.
    pub fn read_paths_by(&self, reader: Arc<dyn PathReader>) {
        let _ = self.paths.set(reader);
    }

    /// Reports a line to the board, and its answer.
    pub fn heard(&self, line: &str, answer: Option<&str>) {
        let exchange = explain::explain(self.time(), line, answer);
        let question = exchange.question;
        if !question || self.listeners.load(Ordering::Relaxed) > 0 {
            self.tell(&LiveMessage::Line(exchange), question);
        }
    }

    /// Accepts no jobs until [`open`](ServeDesk::open), for this reason. Jobs that wait are declined with the
    /// same reason.
    pub fn close(&self, why: Declined) {
        lock(&self.waiting).close(why);
    }

    /// Accepts jobs again.
    pub fn open(&self) {
        lock(&self.waiting).open();
    }

    /// Notes that the board's thread ends: no job is carried out any more, and the server ends.
    pub fn end(&self) {
        self.close(ended());
        self.ended.store(true, Ordering::Relaxed);
        self.gone.notify_waiters();
        self.gone.notify_one();
    }

    fn tell(&self, message: &LiveMessage, question: bool) {
        // There may be no listener.
        let _ = self.told.send(Told { text: json(message), question });
    }
}

impl KeeperDesk for ServeDesk {
    fn time(&self) -> f64 {
        // Whole microseconds make shorter text.
        self.begun.elapsed().as_micros() as f64 / 1e6
    }

    fn is_urgent(&self) -> bool {
        lock(&self.waiting).is_urgent()
    }

    fn is_there(&self, hand: Hand) -> bool {
        lock(&self.control).is_there(hand, Instant::now())
    }

    fn is_live(&self, hand: Hand) -> bool {
        lock(&self.control).is_live(hand, Instant::now())
    }

    fn describe(&self, sheet: BoardSheet) {
        *lock(&self.sheet) = sheet;
    }

    fn publish(&self, state: LiveState) {
        let state = LiveState { time: self.time(), control: self.controller(), ..state };
        let text = json(&LiveMessage::State(state.clone()));
        self.state.send_replace((state, text));
    }

    fn note(&self, text: String) {
        self.tell(&LiveMessage::Note { time: self.time(), text }, false);
    }

    fn plan(&self, curve: PlannedCurve) {
        self.tell(&LiveMessage::Plan(curve), false);
    }

    fn unplan(&self, axis: u8) {
        let time = self.time();
        if let Some(source) = &*lock(&self.scope) {
            source.unplan(axis, time);
        }
        self.tell(&LiveMessage::Unplanned { axis, time }, false);
    }
}

/// The side of the server.
impl ServeDesk {
    /// Gives the board's thread a wish, and waits until its order has begun or ended.
    pub(crate) async fn wish(&self, wish: Wish, waits: bool) -> Result<Done, Declined> {
        if matches!(wish, Wish::Stop(Selection::All) | Wish::Kill) {
            self.stops.fetch_add(1, Ordering::SeqCst);
        }
        // Also while the board is not connected.
        match (&wish, self.paths.get()) {
            (Wish::Stop(Selection::All), Some(paths)) => paths.stop(),
            (Wish::Kill, Some(paths)) => paths.kill(),
            _ => {}
        }
        let (answer, answered) = oneshot::channel();
        lock(&self.waiting).put(Job::new(wish, waits, |done| {
            // The client may be gone.
            let _ = answer.send(done);
        }));
        self.come.notify_one();
        answered.await.unwrap_or_else(|_| Err(ended()))
    }

    /// Accesses the control of the board.
    pub(crate) fn control<T>(&self, ask: impl FnOnce(&mut ControlLease, Instant) -> T) -> T {
        ask(&mut lock(&self.control), Instant::now())
    }

    fn controller(&self) -> Option<Controller> {
        self.control(|control, now| {
            let (hand, name, live) = control.holder(now)?;
            Some(Controller { hand: hand.0, name: name.to_owned(), live })
        })
    }

    /// The board's description.
    pub(crate) fn sheet(&self) -> BoardSheet {
        lock(&self.sheet).clone()
    }

    /// The edges of the last seconds.
    pub(crate) fn scope(&self, seconds: f64) -> Result<ScopeRecord, Declined> {
        let source = lock(&self.scope).clone();
        let source = source.ok_or_else(|| Declined::away("no board was met yet"))?;
        Ok(source.record(seconds, self.time()))
    }

    /// The calculators, if there are any.
    pub(crate) fn calculators(&self) -> Option<&Calculators> {
        self.calculators.get()
    }

    /// Reports the progress of a path's run.
    pub(crate) fn follow_path(&self, report: PathReport) {
        *lock(&self.path) = Some(report.clone());
        self.tell(&LiveMessage::Path(report), false);
    }

    /// The progress of the last run of a path, or how it ended.
    pub(crate) fn path_report(&self) -> Option<PathReport> {
        lock(&self.path).clone()
    }

    /// The number of stops and kills of all axes so far. A request from before the last of them is not begun.
    pub(crate) fn stops(&self) -> usize {
        self.stops.load(Ordering::SeqCst)
    }

    /// The reader of paths, if there is one.
    pub(crate) fn paths(&self) -> Option<Arc<dyn PathReader>> {
        self.paths.get().cloned()
    }

    /// The present state.
    pub(crate) fn state(&self) -> LiveState {
        let state = self.state.borrow().0.clone();
        LiveState { control: self.controller(), ..state }
    }

    /// The states as they come, as text.
    pub(crate) fn states(&self) -> watch::Receiver<(LiveState, Utf8Bytes)> {
        self.state.subscribe()
    }

    /// The lines and plans as they come.
    pub(crate) fn lines(&self) -> broadcast::Receiver<Told> {
        self.told.subscribe()
    }

    /// Waits until the board's thread has ended.
    pub(crate) async fn until_ended(&self) {
        while !self.ended.load(Ordering::Relaxed) {
            self.gone.notified().await;
        }
    }
}

fn ended() -> Declined {
    Declined::away("the server is ending")
}

fn json(message: &LiveMessage) -> Utf8Bytes {
    // There are only numbers and words in it, which JSON can always hold.
    serde_json::to_string(message).unwrap_or_default().into()
}
