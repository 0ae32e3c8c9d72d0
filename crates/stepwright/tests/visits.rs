//! What one visit of an engine on a wide counter does at most.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use stepwright::drive::{Axes, Drive};
use stepwright::queue::{Consumer, Producer, Queue};
use stepwright::timer::StepTimer;
use stepwright::{Engine, Rate, Run, Timing};

/// A counter of 32 bits that stands still in a visit; `pended` is what `wake_at` owes.
#[derive(Clone, Default)]
struct Clock {
    time: Rc<Cell<u32>>,
    wake: Rc<Cell<u32>>,
    pended: Rc<Cell<bool>>,
}

impl StepTimer for Clock {
    type Count = u32;

    fn now(&mut self) -> u32 {
        self.time.get()
    }
    fn wake_at(&mut self, at: u32) {
        self.wake.set(at);
        self.pended.set(at.wrapping_sub(self.time.get()) as i32 <= 0);
    }
    fn set_compare(&mut self, at: u32) {
        self.wake.set(at);
    }
}

/// Steps by time, axes and number.
#[derive(Clone, Default)]
struct Pins {
    clock: Clock,
    steps: Rc<RefCell<Vec<(u32, Axes)>>>,
}

impl Drive for Pins {
    fn begin(&mut self, axes: Axes) {
        self.steps.borrow_mut().push((self.clock.time.get(), axes));
    }
    fn end(&mut self, _: Axes) {}
    fn direction(&mut self, _: u8, _: bool) {}
}

const TIMING: Timing = Timing { pulse: 0, setup: 10, hold: 15, min_interval: 100 };

struct Rig<'q> {
    clock: Clock,
    pins: Pins,
    feeds: Vec<Producer<'q, 8>>,
    engine: Engine<Clock, Pins, Consumer<'q, 8>, 3>,
}

impl<'q> Rig<'q> {
    /// Three axes whose entries are of one step each.
    fn new(queues: &'q mut [Queue<8>; 3]) -> Rig<'q> {
        let clock = Clock::default();
        let pins = Pins { clock: clock.clone(), ..Pins::default() };
        let mut feeds = Vec::new();
        let ends = queues.each_mut().map(|queue| {
            let (mut feed, end) = queue.split();
            feed.set_open(true);
            feeds.push(feed);
            end
        });
        let rate = Rate::from_hz(16_000_000).unwrap();
        let engine = Engine::new(clock.clone(), pins.clone(), ends, TIMING, rate);
        Rig { clock, pins, feeds, engine }
    }

    fn push(&mut self, runs: usize) {
        for feed in &mut self.feeds {
            (0..runs).for_each(|n| feed.push(Run::steady(1_000 + 10 * n as u32, 1)).unwrap());
        }
    }

    /// Entries that have not been taken out of the queues.
    fn waiting(&self) -> u32 {
        self.feeds.iter().map(|feed| u32::from(feed.waiting())).sum()
    }

    /// Visits until it is so; each takes `most` entries at most.
    fn visit_until(&mut self, most: u32, so: impl Fn(&Self) -> bool) {
        for _ in 0..100 {
            if so(self) {
                return;
            }
            let before = self.waiting();
            self.visit();
            assert!(before - self.waiting() <= most, "{before}");
        }
        panic!("100 visits");
    }

    fn made(&self) -> usize {
        self.pins.steps.borrow().len()
    }

    /// A visit, at the time that was asked for.
    fn visit(&mut self) {
        if !self.clock.pended.replace(false) {
            self.clock.time.set(self.clock.wake.get());
        }
        self.engine.on_compare();
    }
}

/// Three axes step at once, again and again, and each visit takes an entry for one of them.
#[test]
fn a_visit_takes_an_entry_for_one_axis() {
    let mut queues = [const { Queue::new() }; 3];
    let mut rig = Rig::new(&mut queues);
    rig.push(6);
    rig.engine.start(0b111);
    rig.visit_until(1, |rig| rig.made() == 5);
    let times: Vec<_> = (1..6).map(|n| (n * 1_000 + 5 * n * (n - 1), 0b111)).collect();
    assert_eq!(*rig.pins.steps.borrow(), times);
    assert_eq!(rig.engine.late(), 0);
}

/// Queues that were empty when they were due are asked one by one, and the steps come together.
#[test]
fn a_visit_asks_one_queue_that_was_empty() {
    let mut queues = [const { Queue::new() }; 3];
    let mut rig = Rig::new(&mut queues);
    rig.push(2);
    rig.engine.start(0b111);
    // The last step of what is there is held back until it is known what follows.
    rig.visit_until(1, |rig| rig.made() == 1 && !rig.clock.pended.get());
    rig.push(2);
    // The entry that is asked for, and the one behind it.
    rig.visit_until(2, |rig| rig.made() == 3);
    assert!(rig.pins.steps.borrow().iter().all(|(_, axes)| *axes == 0b111));
    assert_eq!(rig.engine.late(), 0);
}

/// Whatever the foreground asks between two visits, it sees axes whose steps are counted.
#[test]
fn the_foreground_may_come_between_two_visits() {
    for asked in 0..6 {
        let mut queues = [const { Queue::new() }; 3];
        let mut rig = Rig::new(&mut queues);
        rig.push(6);
        rig.engine.start(0b111);
        // The first of the three that step at once has been seen to.
        rig.visit_until(1, |rig| rig.made() == 1);
        assert!(rig.clock.pended.get());
        match asked {
            0 => {}
            1 => rig.engine.start(0b111),
            2 => drop(rig.engine.playing(2)),
            3 => rig.engine.kill(0b010),
            4 => {
                rig.engine.kill(0b010);
                rig.feeds[1].set_open(true);
                rig.feeds[1].push(Run::steady(900, 3)).unwrap();
                rig.engine.start(0b010);
            }
            _ => {
                let frozen = rig.engine.freeze();
                rig.engine.thaw(frozen);
            }
        }
        for axis in 0..3 {
            assert_eq!(rig.engine.report(axis).position, 1, "axis {axis}, {asked}");
        }
        rig.visit_until(2, |rig| rig.made() == 3);
        let next = match asked {
            3 => [(2_010, 0b101), (3_030, 0b101)],
            4 => [(1_900, 0b010), (2_010, 0b101)],
            _ => [(2_010, 0b111), (3_030, 0b111)],
        };
        assert_eq!(rig.pins.steps.borrow()[1..], next, "{asked}");
    }
}
