//! A chip that takes long to enter the step interrupt, at its minimum interval.

use std::cell::{Cell, RefCell};

use stepwright::drive::Drive;
use stepwright::queue::Queue;
use stepwright::timer::StepTimer;
use stepwright::{Engine, Rate, Run, Timing};

/// Ticks from a deadline to its edge.
const WAY: u32 = 140;

/// The present time, the time of the next interrupt, and the edges.
#[derive(Default)]
struct Chip {
    now: Cell<u32>,
    wake: Cell<u32>,
    edges: RefCell<Vec<u32>>,
}

/// A timer that declares `REACTION` of the time.
struct Timer<'c, const REACTION: u32>(&'c Chip);

impl<const REACTION: u32> StepTimer for Timer<'_, REACTION> {
    type Count = u32;
    const REACTION: u32 = REACTION;
    const SPIN: u32 = u32::MAX;

    fn now(&mut self) -> u32 {
        self.0.now.get()
    }
    fn wake_at(&mut self, at: u32) {
        self.0.wake.set(at);
    }
    fn hold_until(&mut self, _: u32) {}
}

struct Pins<'c>(&'c Chip);

impl Drive for Pins<'_> {
    fn begin(&mut self, _: u8) {
        self.0.edges.borrow_mut().push(self.0.now.get());
    }
    fn end(&mut self, _: u8) {}
    fn direction(&mut self, _: u8, _: bool) {}
}

/// 1,000 steps with this interval: the number of late steps, and all edges.
fn play<const REACTION: u32>(interval: u32, least: u32) -> (u32, Vec<u32>) {
    let (chip, mut queue) = (Chip::default(), Queue::<8>::new());
    let (mut producer, consumer) = queue.split();
    producer.set_open(true);
    producer.push(Run::steady(20_000, 1)).unwrap();
    producer.push(Run::steady(interval, 999)).unwrap();
    producer.set_open(false);
    let timing = Timing { pulse: 32, setup: 16, hold: 16, min_interval: least };
    let timer = Timer::<REACTION>(&chip);
    let mut engine = Engine::new(timer, Pins(&chip), [consumer], timing, Rate::of::<16_000_000>());
    engine.start(1);
    while !engine.report(0).idle {
        // An interrupt ahead takes its time; what has passed is served in the same visit.
        chip.now.set(chip.wake.get().wrapping_add(WAY));
        engine.on_compare();
    }
    assert_eq!(engine.report(0).position, 1_000);
    (engine.late(), chip.edges.take())
}

#[test]
fn the_way_into_the_interrupt_is_no_part_of_the_minimum_interval() {
    let (late, edges) = play::<WAY>(1_000, 1_000);
    assert_eq!(late, 0);
    assert!(edges.windows(2).all(|pair| pair[1] - pair[0] >= 1_000));
    assert_eq!(edges[999] - edges[0], 999_000);
    // If it is not declared, each step is delayed by it, and the last ones are late.
    let (late, edges) = play::<0>(1_000, 1_000);
    assert!(late > 500 && edges[999] - edges[0] > 1_100_000, "{late}");
}

/// Two pulses stay apart, however long the declared time is.
#[test]
fn a_pulse_and_a_pause_stay() {
    let timing = Timing { pulse: 32, setup: 16, hold: 16, min_interval: 64 };
    let (chip, mut queue) = (Chip::default(), Queue::<8>::new());
    let (_, consumer) = queue.split();
    let timer = Timer::<WAY>(&chip);
    let engine = Engine::new(timer, Pins(&chip), [consumer], timing, Rate::of::<16_000_000>());
    assert_eq!(engine.timing().min_interval, 64);
}
