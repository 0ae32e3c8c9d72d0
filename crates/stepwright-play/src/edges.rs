//! The last edges of a virtual board's pins, for a view of them while the board runs, and for files.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use stepwright_host::link::bench::BenchRecorder;
use stepwright_keeper::scope::{ScopeRecord, ScopeSignal, ScopeSource};
use stepwright_sim::{Edge, Pin, Recorder};

use crate::cycle::PlayTape;

/// The last edges, shared between the board and its viewers.
#[derive(Clone)]
pub struct EdgeStore(Arc<Mutex<Kept>>);

/// A pin of an axis, and its signal without edges: with the level before the first edge that is kept.
struct KeptPin {
    axis: u8,
    pin: Pin,
    signal: ScopeSignal,
}

struct Kept {
    hz: u32,
    /// The number of edges that are kept, and their greatest age in ticks.
    most: usize,
    longest: u64,
    /// The number of recordings in progress; without one no edges are kept.
    recordings: usize,
    /// The present, in ticks.
    now: u64,
    edges: VecDeque<Edge>,
    pins: Vec<KeptPin>,
    /// The last rise of each STEP.
    rises: [Option<u64>; 8],
    /// Edges before this tick are no longer kept.
    since: u64,
}

impl EdgeStore {
    /// Records the edges of these pins, each with its level before its first edge if that is known.
    /// Keeps at most this many edges.
    pub fn new(
        hz: u32,
        most: usize,
        pins: impl IntoIterator<Item = (u8, Pin, Option<bool>)>,
    ) -> EdgeStore {
        let kept = |(axis, pin, level)| {
            let own = |name| ScopeSignal::new(Some(axis + 1), name);
            let signal = match pin {
                Pin::Step => own("step"),
                Pin::Direction => own("dir"),
                Pin::Coil(_) => ScopeSignal { name: pin.of(axis), ..own("coil") },
                Pin::Enable => own("enable"),
                Pin::Min => own("min"),
                Pin::Max => own("max"),
            };
            KeptPin { axis, pin, signal: ScopeSignal { level, ..signal } }
        };
        EdgeStore(Arc::new(Mutex::new(Kept {
            hz,
            most,
            longest: u64::MAX,
            recordings: 1,
            now: 0,
            edges: VecDeque::new(),
            pins: pins.into_iter().map(kept).collect(),
            rises: [None; 8],
            since: 0,
        })))
    }

    /// Also records the enable pin that all axes share.
    pub fn with_enable(self) -> EdgeStore {
        let signal = ScopeSignal::new(None, "enable");
        self.kept().pins.push(KeptPin { axis: 0, pin: Pin::Enable, signal });
        self
    }

    /// Forgets edges that are older than this.
    pub fn for_seconds(self, seconds: f64) -> EdgeStore {
        let mut kept = self.kept();
        kept.longest = (seconds * f64::from(kept.hz)) as u64;
        drop(kept);
        self
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        // No change of the store can be left half done by a panic.
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

    /// Ends a recording. A new store has one.
    pub fn end(&self) {
        let mut kept = self.kept();
        kept.recordings = kept.recordings.saturating_sub(1);
        while kept.recordings == 0 && kept.forget() {}
    }

    /// The rise of an axis' STEP since the last call, in ticks. A step counts at the end of its pulse.
    pub fn take_rise(&self, axis: usize) -> Option<u64> {
        self.kept().rises.get_mut(axis).and_then(Option::take)
    }
}

impl BenchRecorder for EdgeStore {
    fn pass(&mut self, now: u64, enables: &[(u64, bool)]) {
        let mut kept = self.kept();
        kept.now = now;
        for &(time, level) in enables {
            kept.add(Edge { time, axis: 0, pin: Pin::Enable, level });
        }
        let longest = kept.longest;
        while kept.edges.front().is_some_and(|edge| edge.time.saturating_add(longest) < now) {
            kept.forget();
        }
    }
}

impl Recorder for EdgeStore {
    fn edge(&mut self, edge: Edge) {
        self.kept().add(edge);
    }
}

impl PlayTape for EdgeStore {}

impl Kept {
    fn add(&mut self, edge: Edge) {
        if edge.is_step()
            && let Some(rise) = self.rises.get_mut(usize::from(edge.axis))
        {
            *rise = Some(edge.time);
        }
        self.edges.push_back(edge);
        if self.recordings == 0 || self.edges.len() > self.most {
            self.forget();
        }
    }

    /// Forgets the oldest edge. Returns whether there was one.
    fn forget(&mut self) -> bool {
        let Some(edge) = self.edges.pop_front() else { return false };
        self.since = self.since.max(edge.time);
        let mut pins = self.pins.iter_mut();
        if let Some(pin) = pins.find(|one| (one.axis, one.pin) == (edge.axis, edge.pin)) {
            pin.signal.level = Some(edge.level);
        }
        true
    }
}

impl ScopeSource for EdgeStore {
    fn record(&self, seconds: f64, _: f64) -> ScopeRecord {
        let kept = self.kept();
        let (hz, end) = (kept.hz, kept.now);
        let long = (seconds * f64::from(hz)) as u64;
        let begin = end.saturating_sub(long).max(kept.since);
        let signal = |KeptPin { axis, pin, signal }: &KeptPin| {
            let mut signal = signal.clone();
            let (mut last, mut level) = (begin, signal.level);
            for edge in kept.edges.iter().filter(|edge| (edge.axis, edge.pin) == (*axis, *pin)) {
                if edge.time < begin {
                    (signal.level, level) = (Some(edge.level), Some(edge.level));
                    continue;
                }
                // The level before the first edge was not known; it follows from that edge.
                if level.is_none() {
                    signal.level = Some(!edge.level);
                }
                if level != Some(edge.level) {
                    signal.edges.push(edge.time - last);
                    (last, level) = (edge.time, Some(edge.level));
                }
            }
            signal
        };
        let signals = kept.pins.iter().map(signal).collect();
        let words = "the edges of the virtual board's pins".into();
        ScopeRecord { source: "pins".into(), words, hz, begin, end, signals }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stepwright_sim::Description;

    /// The number of edges that are kept here.
    const KEPT: usize = 200_000;

    fn of(description: &Description) -> EdgeStore {
        let store = EdgeStore::new(16_000_000, KEPT, description.pins());
        store.with_enable().for_seconds(10.0)
    }

    fn store() -> EdgeStore {
        of(&Description::uno())
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
        let mut store = of(&Description::uno().with_drives(&drives));
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
    fn without_a_recording_only_levels_are_kept() {
        let mut store = store();
        store.end();
        store.edge(edge(10, 0, Pin::Direction, true));
        store.edge(edge(90, 0, Pin::Step, true));
        assert_eq!((store.take_rise(0), store.take_rise(0)), (Some(90), None));
        store.pass(100, &[]);
        store.begin();
        store.edge(edge(140, 0, Pin::Step, false));
        store.pass(200, &[]);
        let record = store.record(1.0, 0.0);
        assert_eq!((record.begin, record.end), (100, 200));
        assert_eq!(signal(&record, "dir1").level, Some(true));
        let step = signal(&record, "step1");
        assert_eq!((step.level, step.edges), (Some(true), vec![40]));
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
