//! A far step on a wide counter: it is fetched before it is due.

use std::cell::Cell;

use stepwright::drive::Drive;
use stepwright::queue::Queue;
use stepwright::timer::StepTimer;
use stepwright::{Engine, Playing, Rate, Run, Timing};

/// The present time, and the time of the next interrupt.
#[derive(Default)]
struct Chip {
    now: Cell<u32>,
    wake: Cell<u32>,
    /// The last edge.
    edge: Cell<u32>,
}

impl StepTimer for &Chip {
    type Count = u32;

    fn now(&mut self) -> u32 {
        self.now.get()
    }
    fn wake_at(&mut self, at: u32) {
        self.wake.set(at);
    }
}

impl Drive for &Chip {
    fn begin(&mut self, _: u8) {
        self.edge.set(self.now.get());
    }
    fn end(&mut self, _: u8) {}
    fn direction(&mut self, _: u8, _: bool) {}
}

/// Ticks to the first step.
const BEGIN: u32 = 20_000;

/// Plays a step, `lag` ticks late, and one that comes `far` after it. The second is queued `ahead`
/// of its deadline. Returns whether it was fetched before its deadline, the number of late steps,
/// and its edge.
fn play(far: u32, ahead: u32, lag: u32) -> (bool, u32, u32) {
    let (chip, mut queue) = (Chip::default(), Queue::<8>::new());
    let (mut producer, consumer) = queue.split();
    producer.set_open(true);
    producer.push(Run::steady(BEGIN, 1)).unwrap();
    // The wait of a step is the time to the next one: the second waits until the third is known.
    producer.push(Run::steady(far, 1)).unwrap();
    let timing = Timing { pulse: 0, setup: 0, hold: 0, min_interval: 1_000 };
    let mut engine = Engine::new(&chip, &chip, [consumer], timing, Rate::of::<1_000_000>());
    engine.start(1);
    let due = BEGIN + far;
    let (mut pushed, mut fetched) = (false, false);
    for at in (0..due + 1_000).step_by(100) {
        chip.now.set(at);
        if !pushed && at + ahead >= due {
            producer.push(Run::steady(far, 1)).unwrap();
            pushed = true;
        } else if !pushed && at > BEGIN + 0x8000 {
            assert_eq!(engine.playing(0), Playing::Dry(due.saturating_sub(at)), "{at}");
        }
        let held = (BEGIN..BEGIN + lag).contains(&at);
        while !held && chip.wake.get().wrapping_sub(at) as i32 <= 0 {
            engine.on_compare();
        }
        fetched |= at < due && pushed && producer.waiting() == 0;
    }
    assert_eq!(engine.report(0).position, 2);
    (fetched, engine.late(), chip.edge.get())
}

#[test]
fn a_step_that_is_far_is_fetched_before_it_is_due() {
    for ahead in [200_000, 5_000] {
        assert_eq!(play(320_000, ahead, 0), (true, 0, BEGIN + 320_000));
    }
    assert_eq!(play(20_000, 5_000, 0), (true, 0, BEGIN + 20_000));
}

/// Between the early read and its deadline it is on time, as at any other time.
#[test]
fn one_that_comes_after_the_look_is_on_time_too() {
    for ahead in [3_000, 0] {
        assert_eq!(play(320_000, ahead, 0), (false, 0, BEGIN + 320_000));
    }
}

/// The step before it is late by half an interval, as at any other time.
#[test]
fn a_look_ahead_makes_no_step_late() {
    assert_eq!(play(20_000, 5_000, 9_900), (true, 0, BEGIN + 20_000));
    assert_eq!(play(20_000, 5_000, 10_100), (true, 1, BEGIN + 20_000));
}
