//! The desk between the threads of a program and the thread of its board.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

use stepwright_keeper::pulses::PlannedPins;
use stepwright_keeper::report::{BoardSheet, LiveState, PlannedCurve};
use stepwright_keeper::scope::ScopeSource;
use stepwright_keeper::{Declined, Hand, Job, JobQueue, KeeperDesk, Wish};
use stepwright_play::edges::EdgeStore;

use crate::ticket::{Stage, Ticket};
use crate::track::Tracks;

/// The hand that asks: a program has its board for itself.
pub const HAND: Hand = Hand(1);

/// The number of notes that are kept.
const NOTES: usize = 100;

/// The progress of the board's thread.
#[derive(Clone, Debug)]
pub enum Met {
    /// The thread has not met the board yet.
    NotYet,
    /// The thread keeps the board.
    Kept,
    /// The thread has ended: it let the board go, or the reason why not.
    Ended(Option<Declined>),
}

/// The next task of the board's thread.
pub enum Next {
    /// A job, or the work that is due.
    Turn(Option<Job>),
    /// Let this time pass on the board, because somebody waits.
    Pass(Duration),
    /// Brake all motors and end.
    Leave,
}

/// The source of the pins' edges.
#[derive(Clone)]
pub enum Probe {
    /// The pins of a virtual board.
    Pins(EdgeStore),
    /// The planned pulses, if the board is known only through a line.
    Plans(Arc<PlannedPins>),
}

/// An event that somebody waits for.
pub enum Awaited {
    /// A time of the board's clock in s.
    Time(f64),
    /// The end of an order.
    End(Arc<Ticket>),
}

/// The desk of a board.
pub struct Desk {
    /// Whether time passes only while somebody waits for it.
    fast: bool,
    began: Instant,
    /// The time of a fast board in ns.
    clock: AtomicU64,
    leaves: AtomicBool,
    work: Mutex<Work>,
    /// Signalled when there is work.
    worked: Condvar,
    told: Mutex<Told>,
    /// Signalled when the thread has told something.
    heard: Condvar,
}

#[derive(Default)]
struct Work {
    jobs: JobQueue,
    /// Runs that end at a time: the time, the order, and how to end it.
    due: Vec<(f64, Arc<Ticket>, Wish)>,
    /// The events that are waited for on a fast board, by number.
    awaited: Vec<(u64, Awaited)>,
    waits: u64,
}

impl Work {
    /// How long the time of a fast board may pass: until the next time that somebody waits for. `None` if
    /// nobody waits.
    fn may_pass(&mut self, now: f64, pause: f64) -> Option<f64> {
        self.awaited.retain(|(_, what)| match what {
            Awaited::Time(time) => *time > now,
            Awaited::End(ticket) => !ticket.is(Stage::Ended),
        });
        let times = self.awaited.iter().filter_map(|(_, what)| match what {
            Awaited::Time(time) => Some(time - now),
            Awaited::End(_) => None,
        });
        let until = times.fold(pause, f64::min);
        (!self.awaited.is_empty()).then_some(until)
    }
}

struct Told {
    met: Met,
    sheet: BoardSheet,
    state: LiveState,
    notes: Vec<String>,
    recorders: Vec<Weak<Tracks>>,
    probe: Option<Probe>,
}

impl Desk {
    /// The desk of a board that is not met yet.
    pub fn new(fast: bool) -> Desk {
        let (sheet, state) = (BoardSheet::default(), LiveState::default());
        let (notes, recorders) = (Vec::new(), Vec::new());
        Desk {
            fast,
            began: Instant::now(),
            clock: AtomicU64::new(0),
            leaves: AtomicBool::new(false),
            work: Mutex::default(),
            worked: Condvar::new(),
            told: Mutex::new(Told {
                met: Met::NotYet,
                sheet,
                state,
                notes,
                recorders,
                probe: None,
            }),
            heard: Condvar::new(),
        }
    }

    fn work(&self) -> MutexGuard<'_, Work> {
        // Every change leaves a complete state.
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn told(&self) -> MutexGuard<'_, Told> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the time of a fast board.
    pub fn pass(&self, now: Duration) {
        self.clock.store(u64::try_from(now.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
        if self.fast {
            self.heard.notify_all();
        }
    }

    /// Gives a job to the board's thread.
    pub fn put(&self, job: Job) {
        self.work().jobs.put(job);
        self.worked.notify_all();
    }

    /// Ends the run of this order at a time.
    pub fn end_at(&self, time: f64, ticket: Arc<Ticket>, by: Wish) {
        self.work().due.push((time, ticket, by));
        self.worked.notify_all();
    }

    /// Notes that somebody waits for this event, until it comes or [`forgo`](Desk::forgo) is called with the
    /// returned number.
    pub fn waits_for(&self, what: Awaited) -> u64 {
        let mut work = self.work();
        work.waits += 1;
        let number = work.waits;
        // With real time the list is not needed, and nothing would remove the entry.
        if self.fast {
            work.awaited.push((number, what));
        }
        drop(work);
        self.worked.notify_all();
        number
    }

    /// Removes the wait with this number.
    pub fn forgo(&self, number: u64) {
        self.work().awaited.retain(|(one, _)| *one != number);
    }

    /// Makes the thread brake all motors and end.
    pub fn leave(&self) {
        self.leaves.store(true, Ordering::SeqCst);
        drop(self.work());
        self.worked.notify_all();
    }

    /// Whether the thread has to end.
    pub fn leaves(&self) -> bool {
        self.leaves.load(Ordering::SeqCst)
    }

    /// Waits for the next task of the thread, for at most `pause`.
    pub fn next(&self, pause: Duration) -> Next {
        let end = Instant::now() + pause;
        let mut work = self.work();
        loop {
            if self.leaves() {
                return Next::Leave;
            }
            if let Some(job) = work.jobs.take() {
                return Next::Turn(Some(job));
            }
            let now = self.time();
            work.due.retain(|(_, ticket, _)| !ticket.is(Stage::Ended));
            if let Some(place) = work.due.iter().position(|(time, ..)| *time <= now) {
                let (_, ticket, wish) = work.due.swap_remove(place);
                ticket.time_is_over();
                return Next::Turn(Some(Job::new(wish, false, |_| ())));
            }
            let next = work.due.iter().map(|(time, ..)| time - now).reduce(f64::min);
            let next = next.and_then(|left| Duration::try_from_secs_f64(left).ok());
            if self.fast {
                let pause = next.map_or(pause, |next| next.min(pause)).as_secs_f64();
                if let Some(time) = work.may_pass(now, pause) {
                    return Next::Pass(Duration::try_from_secs_f64(time).unwrap_or_default());
                }
                work = self.worked.wait(work).unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Next::Turn(None);
            }
            let left = next.map_or(left, |next| next.min(left));
            work = self.worked.wait_timeout(work, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Takes no more jobs, for this reason.
    pub fn close(&self, why: Declined) {
        self.work().jobs.close(why);
    }

    /// Sets the progress of the thread.
    pub fn meets(&self, met: Met) {
        self.told().met = met;
        self.heard.notify_all();
    }

    /// The progress of the thread.
    pub fn met(&self) -> Met {
        self.told().met.clone()
    }

    /// Waits until `holds`, for at most `limit`. Returns whether it does.
    pub fn wait(&self, limit: Duration, mut holds: impl FnMut(&Met, f64) -> bool) -> bool {
        let end = Instant::now() + limit;
        let mut told = self.told();
        loop {
            if holds(&told.met, self.time()) {
                return true;
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            told = self.heard.wait_timeout(told, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// The description of the board.
    pub fn sheet(&self) -> BoardSheet {
        self.told().sheet.clone()
    }

    /// The state of the board.
    pub fn state(&self) -> LiveState {
        self.told().state.clone()
    }

    /// Sets the source of the pins' edges.
    pub fn probe(&self, probe: Probe) {
        self.told().probe = Some(probe);
    }

    /// The source of the pins' edges.
    pub fn probed(&self) -> Option<Probe> {
        self.told().probe.clone()
    }

    /// Takes the notes for people. Each is returned once.
    pub fn take_notes(&self) -> Vec<String> {
        std::mem::take(&mut self.told().notes)
    }

    /// Makes this recorder see all reports from now on, as long as it is held.
    pub fn record(&self, tracks: &Arc<Tracks>) {
        let mut told = self.told();
        tracks.see(&told.state);
        told.recorders.push(Arc::downgrade(tracks));
    }

    /// Makes this recorder see no more reports.
    pub fn end_record(&self, tracks: &Arc<Tracks>) {
        self.told().recorders.retain(|one| !std::ptr::eq(one.as_ptr(), Arc::as_ptr(tracks)));
    }
}

impl KeeperDesk for Desk {
    fn time(&self) -> f64 {
        match self.fast {
            true => self.clock.load(Ordering::Relaxed) as f64 / 1e9,
            false => self.began.elapsed().as_secs_f64(),
        }
    }

    fn is_urgent(&self) -> bool {
        self.work().jobs.is_urgent()
    }

    fn is_there(&self, hand: Hand) -> bool {
        hand == HAND
    }

    fn is_live(&self, hand: Hand) -> bool {
        hand == HAND
    }

    fn describe(&self, sheet: BoardSheet) {
        self.told().sheet = sheet;
    }

    fn publish(&self, state: LiveState) {
        let mut told = self.told();
        told.recorders.retain(|recorder| match recorder.upgrade() {
            Some(recorder) => {
                recorder.see(&state);
                true
            }
            None => false,
        });
        told.state = LiveState { time: self.time(), ..state };
        drop(told);
        self.heard.notify_all();
    }

    fn note(&self, text: String) {
        let mut told = self.told();
        told.notes.push(text);
        let many = told.notes.len().saturating_sub(NOTES);
        told.notes.drain(..many);
    }

    fn plan(&self, _: PlannedCurve) {}

    fn unplan(&self, axis: u8) {
        if let Some(Probe::Plans(pulses)) = self.probed() {
            pulses.unplan(axis, self.time());
        }
    }
}
