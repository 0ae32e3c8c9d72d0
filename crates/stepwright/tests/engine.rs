//! The engine alone, on a timer that the test moves: late interrupts, empty feeds, long intervals,
//! kills.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use stepwright::drive::{Axes, Drive};
use stepwright::queue::{Asked, Feed, Queue, Taken};
use stepwright::timer::StepTimer;
use stepwright::{Engine, Rate, Run, Timing};

/// A 16-bit counter; `lag` is the delay of the interrupt.
#[derive(Clone, Default)]
struct Clock {
    time: Rc<Cell<u64>>,
    wake: Rc<Cell<u64>>,
}

impl StepTimer for Clock {
    type Count = u16;
    const SPIN: u32 = u32::MAX;

    fn now(&mut self) -> u16 {
        self.time.get() as u16
    }
    fn wake_at(&mut self, at: u16) {
        // A time that has passed comes at the next tick.
        let ahead = (at.wrapping_sub(self.time.get() as u16) as i16).max(1);
        self.wake.set(self.time.get() + ahead as u64);
    }
    fn hold_until(&mut self, at: u16) {
        let ahead = at.wrapping_sub(self.time.get() as u16) as i16;
        self.time.set(self.time.get() + ahead.max(0) as u64);
    }
}

#[derive(Clone, Default)]
struct Pins {
    clock: Clock,
    steps: Rc<RefCell<Vec<(u64, u8)>>>,
    turns: Rc<RefCell<Vec<(u64, u8, bool)>>>,
    high: Rc<Cell<Axes>>,
}

impl Drive for Pins {
    fn begin(&mut self, axes: Axes) {
        assert_eq!(self.high.get() & axes, 0, "a pulse within a pulse");
        self.high.set(self.high.get() | axes);
        for axis in (0..8).filter(|axis| axes >> axis & 1 != 0) {
            self.steps.borrow_mut().push((self.clock.time.get(), axis));
        }
    }
    fn end(&mut self, axes: Axes) {
        self.high.set(self.high.get() & !axes);
    }
    fn direction(&mut self, axis: u8, forward: bool) {
        self.turns.borrow_mut().push((self.clock.time.get(), axis, forward));
    }
}

/// Runs in a list; `open` while more may come.
#[derive(Clone, Default)]
struct List {
    runs: Rc<RefCell<VecDeque<Run>>>,
    open: Rc<Cell<bool>>,
}

impl Feed for List {
    fn take(&mut self) -> Taken {
        match self.runs.borrow_mut().pop_front() {
            Some(run) => Taken::Run(run),
            None if self.open.get() => Taken::Late,
            None => Taken::End,
        }
    }
    fn clear(&mut self) {
        self.runs.borrow_mut().clear();
        self.open.set(false);
    }
}

const MIN: u32 = 100;

struct Rig<const N: usize> {
    clock: Clock,
    pins: Pins,
    feeds: [List; N],
    engine: Engine<Clock, Pins, Asked<List>, N>,
}

impl<const N: usize> Rig<N> {
    fn new() -> Rig<N> {
        let clock = Clock::default();
        let pins = Pins { clock: clock.clone(), ..Pins::default() };
        let feeds: [List; N] = core::array::from_fn(|_| List::default());
        let timing = Timing { pulse: 20, setup: 10, hold: 15, min_interval: MIN };
        let rate = Rate::from_hz(8_000_000).unwrap();
        let engine =
            Engine::new(clock.clone(), pins.clone(), feeds.clone().map(Asked::new), timing, rate);
        pins.turns.borrow_mut().clear();
        Rig { clock, pins, feeds, engine }
    }

    fn feed(&self, axis: usize, runs: &[Run]) {
        self.feeds[axis].runs.borrow_mut().extend(runs);
    }

    /// Serves interrupts on time until `end`.
    fn run_until(&mut self, end: u64) {
        while self.clock.wake.get() <= end {
            self.clock.time.set(self.clock.wake.get().max(self.clock.time.get()));
            self.engine.on_compare();
        }
        self.clock.time.set(end.max(self.clock.time.get()));
    }

    fn steps(&self, axis: u8) -> Vec<u64> {
        self.pins.steps.borrow().iter().filter(|s| s.1 == axis).map(|s| s.0).collect()
    }
}

#[test]
fn unrelated_axes_keep_their_own_deadlines() {
    let mut rig = Rig::<3>::new();
    rig.feed(0, &[Run::steady(1_000, 50)]);
    rig.feed(1, &[Run::steady(1_501, 30)]);
    rig.feed(2, &[Run::steady(777, 60)]);
    rig.engine.start(0b111);
    rig.run_until(100_000);
    for (axis, interval, count) in [(0, 1_000, 50), (1, 1_501, 30), (2, 777, 60)] {
        let steps = rig.steps(axis);
        assert_eq!(steps.len(), count);
        // During the pulse of another axis a step waits for its end.
        for (n, t) in steps.iter().enumerate() {
            let deadline = interval * (n as u64 + 1);
            assert!((deadline..=deadline + 20).contains(t), "axis {axis} step {n}: {t}");
        }
    }
    assert_eq!(rig.engine.late(), 0);
    assert!(rig.engine.report(1).idle);
    assert_eq!(rig.engine.report(1).position, 30);
}

#[test]
fn intervals_beyond_the_counter_are_waited_out() {
    let mut rig = Rig::<1>::new();
    rig.feed(0, &[Run::steady(28_671, 2), Run::steady(28_672, 2), Run::steady(1_000_000, 3)]);
    rig.feed(0, &[Run::steady(u32::MAX, 1), Run::steady(500, 1)]);
    rig.engine.start(1);
    rig.run_until(5_000_000_000);
    let mut at = 0;
    let wanted: Vec<u64> =
        [28_671, 28_671, 28_672, 28_672, 1_000_000, 1_000_000, 1_000_000, u32::MAX.into(), 500]
            .iter()
            .map(|t| {
                at += t;
                at
            })
            .collect();
    assert_eq!(rig.steps(0), wanted);
    assert_eq!((rig.engine.late(), rig.engine.report(0).position), (0, 9));
}

/// The position counts the emitted steps, in the middle of a run too.
#[test]
fn positions_are_known_on_the_way() {
    let mut rig = Rig::<1>::new();
    rig.feed(0, &[Run::steady(1_000, 5), Run::steady(40_000, 4), Run::turn(15, false)]);
    rig.feed(0, &[Run::steady(1_000, 7)]);
    rig.engine.start(1);
    for (until, position) in [(999, 0), (3_500, 3), (5_500, 5), (50_000, 6), (130_000, 8)] {
        rig.run_until(until);
        assert_eq!(rig.engine.report(0).position, position, "at {until}");
    }
    rig.run_until(168_500);
    assert_eq!(rig.engine.report(0).position, 6);
    rig.run_until(200_000);
    assert_eq!((rig.engine.report(0).position, rig.engine.report(0).forward), (2, false));
}

#[test]
fn a_late_step_is_counted_and_caught_up_at_the_minimum_interval() {
    let mut rig = Rig::<1>::new();
    rig.feed(0, &[Run::steady(200, 40)]);
    rig.engine.start(1);
    rig.run_until(1_900);
    // Interrupts were held off for 450 ticks: past 2000, 2200 and half.
    rig.clock.time.set(2_350);
    rig.engine.on_compare();
    rig.run_until(20_000);
    let steps = rig.steps(0);
    assert_eq!(steps.len(), 40);
    assert_eq!(steps[9], 2_350);
    for pair in steps.windows(2) {
        assert!(pair[1] - pair[0] >= u64::from(MIN), "{pair:?}");
    }
    // 2350 − 2000 = 350 late, 100 gained per step: 250, 150, then within half.
    assert_eq!(&steps[9..14], &[2_350, 2_450, 2_550, 2_650, 2_800]);
    assert_eq!(rig.engine.late(), 3);
    assert_eq!(steps[39], 8_000);
    assert_eq!(rig.engine.report(0).position, 40);
}

#[test]
fn a_step_that_is_not_late_still_keeps_the_minimum_interval() {
    // One run that is played repeatedly, and runs of one step each.
    for runs in [vec![Run::steady(150, 6)], vec![Run::steady(150, 1); 6]] {
        let mut rig = Rig::<1>::new();
        rig.feed(0, &runs);
        rig.engine.start(1);
        rig.run_until(400);
        // 70 ticks after its time: half an interval less 5.
        rig.clock.time.set(520);
        rig.engine.on_compare();
        rig.run_until(2_000);
        assert_eq!(rig.engine.late(), 0);
        assert_eq!(rig.steps(0), [150, 300, 520, 620, 750, 900]);
    }
}

#[test]
fn the_interrupt_says_when_a_travel_has_ended_or_a_step_was_late() {
    let mut rig = Rig::<2>::new();
    rig.feed(0, &[Run::steady(1_000, 4)]);
    rig.feed(1, &[Run::steady(1_000, 2)]);
    rig.feed(1, &[Run::steady(700, 5)]);
    rig.engine.start(0b11);
    let mut news = Vec::new();
    while !rig.engine.rests() {
        let late = if rig.clock.wake.get() == 3_400 { 600 } else { 0 };
        let time = rig.clock.wake.get().max(rig.clock.time.get()) + late;
        rig.clock.time.set(time);
        if rig.engine.on_compare() {
            news.push(time);
        }
    }
    // A late step at 4,000, where the first axis ends; two that catch up, and the end.
    assert_eq!((rig.engine.late(), rig.steps(0).len(), rig.steps(1).len()), (1, 4, 7));
    assert_eq!((news[0], *news.last().unwrap()), (4_000, *rig.steps(1).last().unwrap()));
    assert!(news.len() <= 3, "{news:?}");
}

#[test]
fn half_an_interval_and_a_microsecond_are_not_late() {
    let mut rig = Rig::<1>::new();
    rig.feed(0, &[Run::steady(1_000, 3)]);
    rig.engine.start(1);
    // 8 ticks are 1 µs.
    rig.clock.time.set(1_508);
    rig.engine.on_compare();
    assert_eq!(rig.engine.late(), 0);
    rig.clock.time.set(2_509);
    rig.engine.on_compare();
    assert_eq!(rig.engine.late(), 1);
    rig.run_until(10_000);
    assert_eq!(rig.steps(0), [1_508, 2_509, 3_000]);
}

#[test]
fn a_feed_that_runs_dry_makes_one_late_step_and_slips() {
    let mut rig = Rig::<1>::new();
    rig.feeds[0].open.set(true);
    rig.feed(0, &[Run::steady(1_000, 2)]);
    rig.engine.start(1);
    rig.run_until(50_000);
    assert!(!rig.engine.report(0).idle, "the travel is not over");
    rig.feed(0, &[Run::steady(1_000, 3)]);
    rig.feeds[0].open.set(false);
    rig.run_until(100_000);
    let steps = rig.steps(0);
    assert_eq!(steps.len(), 5);
    // From rest at its own interval, not in a burst.
    assert!(steps[2] > 51_000 && steps[2] <= 51_000 + 64 * u64::from(MIN));
    assert_eq!((steps[3] - steps[2], steps[4] - steps[3]), (1_000, 1_000));
    assert_eq!(rig.engine.late(), 1);
}

#[test]
fn a_turn_waits_for_hold_and_gives_set_up() {
    let mut rig = Rig::<2>::new();
    rig.feed(0, &[Run::steady(500, 2), Run::turn(15, false), Run::steady(110, 2)]);
    rig.engine.start(0b01);
    rig.run_until(5_000);
    // The turn was due at 1,015 and seen at 1,020: it keeps its schedule.
    assert_eq!(rig.steps(0), [500, 1_000, 1_125, 1_235]);
    assert_eq!(*rig.pins.turns.borrow(), [(1_020, 0, false)]);
    assert_eq!(rig.engine.report(0).position, 0);
}

#[test]
fn a_kill_stops_at_once_and_costs_others_nothing() {
    let mut rig = Rig::<2>::new();
    rig.feed(0, &[Run::steady(300, 100)]);
    rig.feed(1, &[Run::steady(301, 100)]);
    rig.engine.start(0b11);
    rig.run_until(3_100);
    rig.engine.kill(0b01);
    rig.run_until(60_000);
    assert_eq!(rig.steps(0).len(), 10);
    assert_eq!((rig.engine.report(0).position, rig.engine.report(0).idle), (10, true));
    assert_eq!(rig.steps(1).len(), 100);
    // And it can start again.
    rig.feed(0, &[Run::steady(300, 5)]);
    rig.engine.start(0b01);
    rig.run_until(100_000);
    assert_eq!(rig.engine.report(0).position, 15);
    assert_eq!(rig.engine.late(), 0);
}

/// Any axis number and any delay: no panic, nothing lost.
#[test]
fn the_edges_of_the_api_hold() {
    let mut rig = Rig::<1>::new();
    assert_eq!(rig.engine.report(200), rig.engine.report(0));
    rig.engine.set_position(9, 5);
    rig.engine.set_position(0, i64::MAX);
    rig.engine.start(0xFE);
    rig.feed(0, &[Run::steady(0, 3), Run::steady(u32::MAX, 1)]);
    rig.engine.start(0xFF);
    rig.run_until(1_000);
    rig.engine.kill(0xFF);
    assert_eq!(rig.engine.report(0).position, i64::MIN + 2);
}

/// Two steps, the second of them 200 ticks late, then a turn, and a step `interval` ticks after
/// the turn.
fn turn_after_a_late_step(interval: u32, forward: bool) -> (Vec<(u64, u8, bool)>, u64) {
    let mut rig = Rig::<1>::new();
    rig.engine.set_timing(Timing { pulse: 20, setup: 10, hold: 60, min_interval: MIN });
    rig.feed(0, &[Run::steady(500, 2), Run::turn(60, forward), Run::steady(interval, 1)]);
    rig.engine.start(1);
    rig.run_until(999);
    rig.clock.time.set(1_200);
    rig.run_until(5_000);
    let turns = rig.pins.turns.borrow().clone();
    (turns, rig.steps(0)[2])
}

/// The same from a queue, whose entries toggle DIR and do not name its level.
#[test]
fn a_turn_from_a_queue_keeps_the_hold_time_too() {
    let clock = Clock::default();
    let pins = Pins { clock: clock.clone(), ..Pins::default() };
    let timing = Timing { pulse: 20, setup: 10, hold: 60, min_interval: MIN };
    let mut queue = Queue::<8>::new();
    let (mut feed, entries) = queue.split();
    let rate = Rate::from_hz(8_000_000).unwrap();
    let mut engine = Engine::new(clock.clone(), pins.clone(), [entries], timing, rate);
    pins.turns.borrow_mut().clear();
    for run in [Run::steady(500, 2), Run::turn(60, false), Run::steady(400, 1)] {
        feed.push(run).unwrap();
    }
    feed.set_open(false);
    engine.start(1);
    while clock.wake.get() < 5_000 && !engine.rests() {
        let late = if clock.wake.get() == 1_000 { 200 } else { 0 };
        clock.time.set(clock.wake.get().max(clock.time.get()) + late);
        engine.on_compare();
    }
    assert_eq!(*pins.turns.borrow(), [(1_260, 0, false)]);
    assert_eq!(pins.steps.borrow()[..2], [(500, 0), (1_200, 0)]);
}

/// The hold time counts from the edge of a late step, and the set-up time from the turn. The
/// schedule is kept if it leaves that time; otherwise it shifts by the delay of the turn.
#[test]
fn a_turn_after_a_late_step_keeps_hold_and_set_up() {
    let turn = vec![(1_260, 0, false)];
    let after = |interval| turn_after_a_late_step(interval, false);
    assert_eq!(after(400), (turn.clone(), 1_460));
    assert_eq!(after(211), (turn.clone(), 1_271));
    assert_eq!(after(210), (turn.clone(), 1_470));
    assert_eq!(after(150), (turn, 1_410));
    // DIR is set to the same side again.
    assert_eq!(turn_after_a_late_step(400, true), (vec![(1_260, 0, true)], 1_460));
}
