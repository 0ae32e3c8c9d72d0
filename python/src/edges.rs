//! The edges of a virtual board's pins while they are recorded.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use stepwright_keeper::scope::{ScopeRecord, ScopeSignal, ScopeSource};
use stepwright_sim::{Description, Edge, Pin};

/// Edges that are kept, at most: 48 MB, and 100 s of an axis at 10,000 steps/s. The oldest go.
const KEPT: usize = 2_000_000;

/// The edges, shared between the board and who records them.
#[derive(Clone)]
pub struct Edges(Arc<Mutex<Kept>>);

struct Kept {
    hz: u32,
    now: u64,
    /// Recordings that go on.
    recordings: usize,
    edges: VecDeque<Edge>,
    pins: Vec<(u8, Pin)>,
    /// Levels before the first edge that is kept.
    before: HashMap<(u8, bool), bool>,
    /// Nothing is known of what was before.
    since: u64,
}

/// An Uno's pins are STEP and DIR alone.
fn key(axis: u8, pin: Pin) -> (u8, bool) {
    (axis, pin == Pin::Step)
}

impl Edges {
    /// Of a board that was just switched on.
    pub fn new(description: &Description) -> Edges {
        let (mut pins, mut before) = (Vec::new(), HashMap::new());
        for (axis, pin, level) in description.pins() {
            pins.push((axis, pin));
            before.extend(level.map(|level| (key(axis, pin), level)));
        }
        let hz = description.board.rate.hz();
        let (edges, recordings) = (VecDeque::new(), 0);
        let kept = Kept { hz, now: 0, recordings, edges, pins, before, since: 0 };
        Edges(Arc::new(Mutex::new(kept)))
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        // Nothing here is changed by halves.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One more recording goes on.
    pub fn begin(&self) {
        let mut kept = self.kept();
        if kept.recordings == 0 {
            kept.since = kept.now;
        }
        kept.recordings += 1;
    }

    /// A recording goes on no more.
    pub fn end(&self) {
        let mut kept = self.kept();
        kept.recordings = kept.recordings.saturating_sub(1);
        if kept.recordings == 0 {
            while kept.forget() {}
        }
    }

    /// It is this time, in ticks.
    pub fn pass(&self, now: u64) {
        self.kept().now = now;
    }

    /// An edge has come.
    pub fn edge(&self, edge: Edge) {
        let mut kept = self.kept();
        kept.edges.push_back(edge);
        if kept.recordings == 0 || kept.edges.len() > KEPT {
            kept.forget();
        }
    }
}

impl Kept {
    /// Forgets the oldest edge; whether there was one.
    fn forget(&mut self) -> bool {
        let Some(edge) = self.edges.pop_front() else { return false };
        self.since = self.since.max(edge.time);
        self.before.insert(key(edge.axis, edge.pin), edge.level);
        true
    }
}

impl ScopeSource for Edges {
    fn record(&self, seconds: f64, _: f64) -> ScopeRecord {
        let kept = self.kept();
        let (hz, end) = (kept.hz, kept.now);
        let long = (seconds * f64::from(hz)) as u64;
        let begin = end.saturating_sub(long).max(kept.since);
        let mut signals = Vec::new();
        for &(axis, pin) in &kept.pins {
            let name = if pin == Pin::Step { "step" } else { "dir" };
            let mut signal = ScopeSignal::new(Some(axis + 1), name);
            signal.level = kept.before.get(&key(axis, pin)).copied();
            let mut last = begin;
            for edge in kept.edges.iter().filter(|edge| (edge.axis, edge.pin) == (axis, pin)) {
                if edge.time < begin {
                    signal.level = Some(edge.level);
                    continue;
                }
                // The first level of a pin of which none was known is the other one.
                signal.level.get_or_insert(!edge.level);
                signal.edges.push(edge.time - last);
                last = edge.time;
            }
            signals.push(signal);
        }
        let words = "the edges of the virtual board's pins".into();
        ScopeRecord { source: "pins".into(), words, hz, begin, end, signals }
    }
}
