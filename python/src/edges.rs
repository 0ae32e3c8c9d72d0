//! The edges of a virtual board's pins while they are recorded.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use stepwright_keeper::scope::{ScopeRecord, ScopeSignal, ScopeSource};
use stepwright_play::cycle::PlayTape;
use stepwright_sim::{Description, Edge, Pin, Recorder};

/// Edges that are kept, at most: 48 MB, and 100 s of an axis at 10,000 steps/s. The oldest go.
const KEPT: usize = 2_000_000;

/// The edges, shared between the board and who records them.
#[derive(Clone)]
pub struct Edges(Arc<Mutex<Kept>>);

struct Kept {
    hz: u32,
    /// How many edges are kept.
    most: usize,
    now: u64,
    /// Recordings that go on.
    recordings: usize,
    edges: VecDeque<Edge>,
    pins: Vec<(u8, Pin)>,
    /// When each STEP rose last.
    rises: [Option<u64>; 8],
    /// Levels before the first edge that is kept.
    before: HashMap<(u8, Pin), bool>,
    /// Nothing is known of what was before.
    since: u64,
}

impl Edges {
    /// Of a board that was just switched on, of which the last ones are kept.
    pub fn new(description: &Description) -> Edges {
        Edges::of(description.board.rate.hz(), KEPT, description.pins())
    }

    /// All of these pins, each of an axis, with its level before its first edge if that is known.
    pub fn all(hz: u32, pins: impl IntoIterator<Item = (u8, Pin, Option<bool>)>) -> Edges {
        let edges = Edges::of(hz, usize::MAX, pins);
        edges.begin();
        edges
    }

    fn of(hz: u32, most: usize, all: impl IntoIterator<Item = (u8, Pin, Option<bool>)>) -> Edges {
        let (mut pins, mut before) = (Vec::new(), HashMap::new());
        for (axis, pin, level) in all {
            pins.push((axis, pin));
            before.extend(level.map(|level| ((axis, pin), level)));
        }
        let (edges, recordings) = (VecDeque::new(), 0);
        let kept =
            Kept { hz, most, now: 0, recordings, edges, pins, before, rises: [None; 8], since: 0 };
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

    /// When STEP of an axis rose since the last call, in ticks. A step is counted as its pulse ends.
    pub fn take_rise(&self, axis: usize) -> Option<u64> {
        self.kept().rises.get_mut(axis).and_then(Option::take)
    }

    /// An edge has come.
    pub fn edge(&self, edge: Edge) {
        let mut kept = self.kept();
        if edge.pin == Pin::Step
            && edge.level
            && let Some(rise) = kept.rises.get_mut(usize::from(edge.axis))
        {
            *rise = Some(edge.time);
        }
        kept.edges.push_back(edge);
        if kept.recordings == 0 || kept.edges.len() > kept.most {
            kept.forget();
        }
    }
}

impl Recorder for Edges {
    fn edge(&mut self, edge: Edge) {
        Edges::edge(self, edge);
    }
}

impl PlayTape for Edges {}

impl Kept {
    /// Forgets the oldest edge; whether there was one.
    fn forget(&mut self) -> bool {
        let Some(edge) = self.edges.pop_front() else { return false };
        self.since = self.since.max(edge.time);
        self.before.insert((edge.axis, edge.pin), edge.level);
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
            let name = match pin {
                Pin::Step => "step",
                Pin::Direction => "dir",
                Pin::Enable => "enable",
                // No board of this package has coils.
                Pin::Min | Pin::Coil(_) => "min",
                Pin::Max => "max",
            };
            let mut signal = ScopeSignal::new(Some(axis + 1), name);
            signal.level = kept.before.get(&(axis, pin)).copied();
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
