//! Pulses that an engine leaves high when its interrupt leaves, on a timer that never waits.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use stepwright::drive::{Axes, Drive};
use stepwright::queue::{Consumer, Queue};
use stepwright::timer::StepTimer;
use stepwright::{Engine, Rate, Run, Timing};

const PULSE: u64 = 20;

/// A counter that stands still during a visit.
#[derive(Clone, Default)]
struct Clock {
    time: Rc<Cell<u64>>,
    wake: Rc<Cell<u64>>,
}

impl StepTimer for Clock {
    type Count = u16;

    fn now(&mut self) -> u16 {
        self.time.get() as u16
    }
    fn wake_at(&mut self, at: u16) {
        let ahead = (at.wrapping_sub(self.time.get() as u16) as i16).max(1);
        self.wake.set(self.time.get() + ahead as u64);
    }
    fn hold_until(&mut self, at: u16) {
        assert_eq!(at, self.time.get() as u16, "nothing is waited for");
    }
}

/// Times, and whether STEP rises or falls then.
type Edges = Vec<(u64, bool)>;

/// Records the edges of each axis.
#[derive(Clone, Default)]
struct Pins {
    clock: Clock,
    high: Rc<Cell<Axes>>,
    edges: Rc<RefCell<[Edges; 2]>>,
}

impl Pins {
    fn note(&self, axes: Axes, high: bool) {
        for (axis, edges) in self.edges.borrow_mut().iter_mut().enumerate() {
            if axes >> axis & 1 != 0 {
                edges.push((self.clock.time.get(), high));
            }
        }
    }
}

impl Drive for Pins {
    fn begin(&mut self, axes: Axes) {
        assert_eq!(self.high.get() & axes, 0, "a pulse within a pulse");
        self.high.set(self.high.get() | axes);
        self.note(axes, true);
    }
    fn end(&mut self, axes: Axes) {
        assert_eq!(self.high.get() & axes, axes, "the end of no pulse");
        self.high.set(self.high.get() & !axes);
        self.note(axes, false);
    }
    fn direction(&mut self, _: u8, _: bool) {}
}

struct Rig<'q> {
    clock: Clock,
    pins: Pins,
    engine: Engine<Clock, Pins, Consumer<'q, 8>, 2>,
}

fn rig<'q>(queues: &'q mut [Queue<8>; 2], runs: [&[Run]; 2]) -> Rig<'q> {
    let clock = Clock::default();
    let pins = Pins { clock: clock.clone(), ..Pins::default() };
    let [x, y] = queues.each_mut().map(Queue::split);
    for (mut feed, runs) in [x.0, y.0].into_iter().zip(runs) {
        feed.set_open(true);
        runs.iter().for_each(|run| feed.push(*run).unwrap());
        feed.set_open(false);
    }
    let timing =
        Timing { pulse: PULSE as u32, setup: 10, hold: 15, min_interval: 2 * PULSE as u32 };
    let rate = Rate::from_hz(8_000_000).unwrap();
    let mut engine = Engine::new(clock.clone(), pins.clone(), [x.1, y.1], timing, rate);
    engine.start(0b11);
    Rig { clock, pins, engine }
}

impl Rig<'_> {
    /// Serves interrupts until `end`; each is delayed by `late` at its time.
    fn run_until(&mut self, end: u64, late: impl Fn(u64) -> u64) {
        while self.clock.wake.get() <= end {
            let wake = self.clock.wake.get().max(self.clock.time.get());
            self.clock.time.set(wake + late(wake));
            self.engine.on_compare();
        }
    }
}

/// A step of one axis within the pulse of another is on time, and each pulse has its length.
#[test]
fn a_step_does_not_wait_for_the_pulse_of_another_axis() {
    let mut queues = [const { Queue::new() }; 2];
    let mut rig = rig(&mut queues, [&[Run::steady(1_000, 5)], &[Run::steady(1_007, 5)]]);
    rig.run_until(9_000, |_| 0);
    for (axis, interval) in [(0, 1_000), (1, 1_007)] {
        let steps = (1..=5).flat_map(|n| [(n * interval, true), (n * interval + PULSE, false)]);
        assert_eq!(rig.pins.edges.borrow()[axis], steps.collect::<Vec<_>>());
    }
    assert_eq!(rig.engine.late(), 0);
}

/// An interrupt that is late ends a pulse late: a driver still sees STEP low for the length of a
/// pulse, and every step is made.
#[test]
fn step_is_low_for_a_pulse_also_where_its_end_is_late() {
    for late in [1, 19, 20, 30, 100, 3_000] {
        let mut queues = [const { Queue::new() }; 2];
        let mut rig = rig(&mut queues, [&[Run::steady(50, 40)], &[Run::steady(333, 9)]]);
        // The end of a pulse of axis 0.
        rig.run_until(30_000, |wake| if wake == 500 + PULSE { late } else { 0 });
        for (axis, steps) in [(0, 40), (1, 9)] {
            let edges = &rig.pins.edges.borrow()[axis];
            assert_eq!(edges.len(), 2 * steps, "{late}");
            for pair in edges.windows(2) {
                let apart = pair[1].0 - pair[0].0;
                assert!(apart >= PULSE, "{late}: {apart} ticks at {}", pair[0].0);
            }
        }
        assert_eq!(rig.pins.high.get(), 0);
    }
}

/// A kill while STEP is high: STEP falls at its time.
#[test]
fn a_pulse_ends_after_a_kill() {
    let mut queues = [const { Queue::new() }; 2];
    let mut rig = rig(&mut queues, [&[Run::steady(1_000, 5)], &[Run::steady(1_500, 5)]]);
    rig.run_until(1_000, |_| 0);
    rig.engine.kill(0b11);
    rig.run_until(9_000, |_| 0);
    assert_eq!(rig.pins.edges.borrow()[0], [(1_000, true), (1_000 + PULSE, false)]);
}

/// Room in a queue is news, and so is the end of a travel.
#[test]
fn an_entry_that_is_taken_is_news() {
    let mut queues = [const { Queue::new() }; 2];
    let runs: [&[Run]; 2] = [&[Run::steady(1_000, 3), Run::steady(900, 3)], &[]];
    let mut rig = rig(&mut queues, runs);
    let mut news = Vec::new();
    while rig.clock.wake.get() < 9_000 {
        rig.clock.time.set(rig.clock.wake.get());
        if rig.engine.on_compare() {
            news.push(rig.clock.time.get());
        }
    }
    // Two steps of the first entry, three of the next, and the last step, which is an entry of its
    // own and the end.
    assert_eq!(news, [2_000, 4_800, 5_700]);
}
