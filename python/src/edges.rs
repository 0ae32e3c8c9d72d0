//! The edges of a virtual board's pins while they are recorded.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use stepwright_keeper::scope::{ScopeRecord, ScopeSignal, ScopeSource};
use stepwright_play::cycle::PlayTape;
use stepwright_sim::{Description, Edge, Pin, Recorder};

/// The most edges that are kept: 48 MB, or 100 s of an axis at 10,000 steps/s. The oldest are dropped.
const KEPT: usize = 2_000_000;

/// The edges, shared between the board and its recorders.
#[derive(Clone)]
pub struct Edges(Arc<Mutex<Kept>>);

struct Kept {
    hz: u32,
    /// The number of edges that are kept.
    most: usize,
    now: u64,
    /// The number of recordings in progress.
    recordings: usize,
    edges: VecDeque<Edge>,
    pins: Vec<(u8, Pin)>,
    /// The last rise of each STEP.
    rises: [Option<u64>; 8],
    /// The levels before the first edge that is kept.
    before: HashMap<(u8, Pin), bool>,
    /// The time before which nothing is known.
    since: u64,
}

impl Edges {
    /// The edges of a board that was just switched on. The last ones are kept.
    pub fn new(description: &Description) -> Edges {
        Edges::of(description.board.rate.hz(), KEPT, description.pins())
    }

    /// All edges of these pins. Each pin has an axis, and its level before its first edge if that is known.
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
        // Every change leaves a complete state.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins a recording.
    pub fn begin(&self) {
        let mut kept = self.kept();
        if kept.recordings == 0 {
            kept.since = kept.now;
        }
        kept.recordings += 1;
    }

    /// Ends a recording.
    pub fn end(&self) {
        let mut kept = self.kept();
        kept.recordings = kept.recordings.saturating_sub(1);
        if kept.recordings == 0 {
            while kept.forget() {}
        }
    }

    /// Sets the time in ticks.
    pub fn pass(&self, now: u64) {
        self.kept().now = now;
    }

    /// The rise of an axis' STEP since the last call, in ticks. A step counts at the end of its pulse.
    pub fn take_rise(&self, axis: usize) -> Option<u64> {
        self.kept().rises.get_mut(axis).and_then(Option::take)
    }

    /// Adds an edge.
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
    /// Forgets the oldest edge. Returns whether there was one.
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
                // If the first level of a pin is not known, it is the opposite of the first edge.
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
