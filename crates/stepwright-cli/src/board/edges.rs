//! Keeps the last edges of a virtual board's pins, for a view of them while the board runs.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use stepwright_keeper::scope::{LONGEST, ScopeRecord, ScopeSignal, ScopeSource};
use stepwright_sim::{Description, Edge, Pin, Recorder};

use super::edge_files::StartLevel;

/// The number of edges that are kept: 10 s of one axis at 10,000 steps/s.
const KEPT: usize = 200_000;

/// The edges of the last seconds, shared between the board and its viewers.
#[derive(Clone)]
pub struct EdgeStore(Arc<Mutex<Kept>>);

struct Kept {
    hz: u32,
    /// The present, in ticks.
    now: u64,
    edges: VecDeque<Edge>,
    /// The pins, with their levels before the first edge that is kept. All axes share one enable
    /// pin, which is listed as that of the first axis.
    before: Vec<StartLevel>,
    /// Ticks: edges before this time are no longer kept.
    since: u64,
}

impl EdgeStore {
    /// The store of a board that was just switched on.
    pub fn new(description: &Description) -> EdgeStore {
        let hz = description.board.rate.hz();
        let before = description.pins().chain([(0, Pin::Enable, None)]).collect();
        let edges = VecDeque::new();
        EdgeStore(Arc::new(Mutex::new(Kept { hz, now: 0, edges, before, since: 0 })))
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        // No change of the store can be left half done by a panic.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the present to `now` ticks, and adds the changes of the enable pin up to then.
    pub fn pass(&self, now: u64, enables: &[(u64, bool)]) {
        let mut kept = self.kept();
        kept.now = now;
        for &(time, level) in enables {
            kept.add(Edge { time, axis: 0, pin: Pin::Enable, level });
        }
        let longest = (LONGEST * f64::from(kept.hz)) as u64;
        while kept.edges.front().is_some_and(|edge| edge.time + longest < now) {
            kept.forget();
        }
    }
}

impl Recorder for EdgeStore {
    fn edge(&mut self, edge: Edge) {
        self.kept().add(edge);
    }
}

impl Kept {
    fn add(&mut self, edge: Edge) {
        self.edges.push_back(edge);
        if self.edges.len() > KEPT {
            self.forget();
        }
    }

    /// Forgets the oldest edge.
    fn forget(&mut self) {
        if let Some(edge) = self.edges.pop_front() {
            self.since = self.since.max(edge.time);
            put(&mut self.before, edge);
        }
    }
}

/// Sets the level of the edge's pin.
fn put(levels: &mut [StartLevel], edge: Edge) {
    let mut pins = levels.iter_mut();
    if let Some(pin) = pins.find(|(axis, pin, _)| (*axis, *pin) == (edge.axis, edge.pin)) {
        pin.2 = Some(edge.level);
    }
}

impl ScopeSource for EdgeStore {
    fn record(&self, seconds: f64, _: f64) -> ScopeRecord {
        let kept = self.kept();
        let (hz, end) = (kept.hz, kept.now);
        let mut edges = Vec::from_iter(kept.edges.iter().copied());
        let mut levels = kept.before.clone();
        let long = (seconds * f64::from(hz)) as u64;
        let begin = end.saturating_sub(long).max(kept.since);
        // Releases the lock, so that the board can continue.
        drop(kept);
        // Edges of the enable pin are added a little later than those of the other pins.
        edges.sort_by_key(|edge| edge.time);
        let first = edges.partition_point(|edge| edge.time < begin);
        edges.iter().take(first).for_each(|edge| put(&mut levels, *edge));
        let mut signals = Vec::new();
        for (axis, pin, known) in levels {
            let mut signal = match pin {
                Pin::Step => ScopeSignal::new(Some(axis + 1), "step"),
                Pin::Direction => ScopeSignal::new(Some(axis + 1), "dir"),
                Pin::Coil(_) => {
                    ScopeSignal { name: pin.of(axis), ..ScopeSignal::new(Some(axis + 1), "coil") }
                }
                _ => ScopeSignal::new(None, "enable"),
            };
            signal.level = known;
            let (mut last, mut level) = (begin, known);
            let mine = |edge: &&Edge| (edge.axis, edge.pin) == (axis, pin);
            for edge in edges.iter().skip(first).filter(mine) {
                // The level before the first edge was not known; it follows from that edge.
                if level.is_none() {
                    signal.level = Some(!edge.level);
                }
                if level != Some(edge.level) {
                    signal.edges.push(edge.time - last);
                    (last, level) = (edge.time, Some(edge.level));
                }
            }
            signals.push(signal);
        }
        let words = "the edges of the virtual board's pins".into();
        ScopeRecord { source: "pins".into(), words, hz, begin, end, signals }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn store() -> EdgeStore {
        EdgeStore::new(&Description::uno())
    }

    fn signal(record: &ScopeRecord, name: &str) -> ScopeSignal {
        record.signals.iter().find(|signal| signal.name == name).cloned().unwrap()
    }

    fn edge(time: u64, axis: u8, pin: Pin, level: bool) -> Edge {
        Edge { time, axis, pin, level }
    }

    #[test]
    fn the_last_seconds_are_told_by_their_edges() {
        let mut store = store();
        for (time, pin, level) in
            [(10, Pin::Direction, false), (100, Pin::Step, true), (132, Pin::Step, false)]
        {
            store.edge(edge(time, 1, pin, level));
        }
        store.pass(16_000, &[(50, false)]);
        let record = store.record(1.0, 0.0);
        assert_eq!((record.hz, record.begin, record.end), (16_000_000, 0, 16_000));
        let names: Vec<_> = record.signals.iter().map(|signal| signal.name.as_str()).collect();
        assert_eq!(names, ["step1", "dir1", "step2", "dir2", "step3", "dir3", "enable"]);
        let step = signal(&record, "step2");
        assert_eq!((step.level, step.edges), (Some(false), vec![100, 32]));
        let dir = signal(&record, "dir2");
        assert_eq!((dir.level, dir.edges), (Some(true), vec![10]));
        assert_eq!(signal(&record, "enable").edges, [50]);
        assert_eq!(signal(&record, "dir1").level, None);
        // Later, in a shorter record: the levels from before it.
        store.edge(edge(31_990_000, 1, Pin::Step, true));
        store.pass(32_000_000, &[]);
        let record = store.record(0.001, 0.0);
        assert_eq!(record.begin, 32_000_000 - 16_000);
        let step = signal(&record, "step2");
        assert_eq!((step.level, step.edges), (Some(false), vec![6_000]));
        assert_eq!(signal(&record, "dir2").level, Some(false));
    }

    #[test]
    fn a_motor_on_coils_has_its_lines_with_their_levels() {
        let drives = ["2:bridge-half".parse().unwrap()];
        let mut store = EdgeStore::new(&Description::uno().with_drives(&drives));
        store.edge(edge(100, 1, Pin::Coil(1), false));
        store.pass(1000, &[]);
        let record = store.record(1.0, 0.0);
        let names: Vec<_> = record.signals.iter().map(|signal| signal.name.as_str()).collect();
        let axis = ["coil2a", "coil2b", "coil2c", "coil2d"];
        assert_eq!(names, [&["step1", "dir1"][..], &axis, &["step3", "dir3", "enable"]].concat());
        let lines: Vec<_> = axis.map(|name| signal(&record, name)).into();
        let levels: Vec<_> = lines.iter().map(|line| line.level.unwrap()).collect();
        assert_eq!(levels, [false, true, false, true]);
        assert_eq!((lines[1].edges.as_slice(), lines[1].pin.as_ref()), (&[100][..], "coil"));
        assert!(lines[0].edges.is_empty());
    }

    #[test]
    fn memory_is_bounded_and_what_is_forgotten_is_not_told() {
        let mut store = store();
        store.edge(edge(0, 0, Pin::Direction, false));
        for n in 0..KEPT as u64 + 1000 {
            store.edge(edge(n * 10, 0, Pin::Step, n % 2 == 0));
        }
        store.pass(10 * (KEPT as u64 + 1000), &[]);
        assert_eq!(store.kept().edges.len(), KEPT);
        let record = store.record(10.0, 0.0);
        assert_eq!(record.begin, 9990);
        // Only the level that the forgotten edge left is known.
        assert_eq!(signal(&record, "dir1").level, Some(false));
        let step = signal(&record, "step1");
        assert_eq!((step.level, step.edges.len(), step.edges[0]), (Some(false), KEPT, 10));
        // No edge is older than the longest record.
        store.pass(16_000_000 * 20, &[]);
        assert_eq!(store.kept().edges.len(), 0);
        assert_eq!(signal(&store.record(1.0, 0.0), "step1").level, Some(false));
    }
}
