//! A cycle on a timer that the test moves: every edge is recorded.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use stepwright::drive::{Axes, Drive};
use stepwright::profile::Fit;
use stepwright::timer::StepTimer;
use stepwright::{Board, Cost, Rate, Timing};
use stepwright_cycle::{Clock, Cycle, MachineIo, Motor, Switches};

/// An event on a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    Rise,
    Fall,
    Dir(bool),
    Enable(Axes),
}

/// A 16-bit counter on 64 bits of time.
#[derive(Clone, Default)]
pub struct Time {
    pub now: Rc<Cell<u64>>,
    wake: Rc<Cell<u64>>,
}

impl StepTimer for Time {
    type Count = u16;
    const SPIN: u32 = u32::MAX;

    fn now(&mut self) -> u16 {
        self.now.get() as u16
    }
    fn wake_at(&mut self, at: u16) {
        // A time that has passed comes at the next tick.
        let ahead = (at.wrapping_sub(self.now.get() as u16) as i16).max(1);
        self.wake.set(self.now.get() + ahead as u64);
    }
    fn hold_until(&mut self, at: u16) {
        let ahead = at.wrapping_sub(self.now.get() as u16) as i16;
        self.now.set(self.now.get() + ahead.max(0) as u64);
    }
}

/// Time, axis, event.
pub type Log = Rc<RefCell<Vec<(u64, u8, What)>>>;

pub struct Pins {
    time: Time,
    log: Log,
}

impl Pins {
    fn say(&self, axes: Axes, what: What) {
        for axis in (0..8).filter(|axis| axes >> axis & 1 != 0) {
            self.log.borrow_mut().push((self.time.now.get(), axis, what));
        }
    }
}

impl Drive for Pins {
    fn begin(&mut self, axes: Axes) {
        self.say(axes, What::Rise);
    }
    fn end(&mut self, axes: Axes) {
        self.say(axes, What::Fall);
    }
    fn direction(&mut self, axis: u8, forward: bool) {
        self.say(1 << axis, What::Dir(forward));
    }
}

pub struct World {
    time: Time,
    log: Log,
    pub closed: Rc<Cell<Switches>>,
}

impl MachineIo for World {
    fn switches(&mut self) -> Switches {
        self.closed.get()
    }
    fn enable(&mut self, axes: Axes) {
        self.log.borrow_mut().push((self.time.now.get(), 255, What::Enable(axes)));
    }
}

pub const HZ: u32 = 16_000_000;
/// The drivers' pulse, in ticks.
pub const PULSE: u64 = 32;

pub struct Rig<'a, const N: usize> {
    pub time: Time,
    pub log: Log,
    pub closed: Rc<Cell<Switches>>,
    pub cycle: Cycle<'a, Time, Pins, World, N>,
    /// The time of the last `start`.
    pub begun: u64,
}

impl<const N: usize> Rig<'_, N> {
    pub fn new(motors: [Motor; N], clock: Clock) -> Self {
        Rig::at(HZ, motors, clock)
    }

    pub fn at(hz: u32, motors: [Motor; N], clock: Clock) -> Self {
        let (time, log) = (Time::default(), Log::default());
        let pins = Pins { time: time.clone(), log: log.clone() };
        let closed = Rc::new(Cell::new(Switches::default()));
        let world = World { time: time.clone(), log: log.clone(), closed: closed.clone() };
        let rate = Rate::from_hz(hz).unwrap();
        let board = Board {
            rate,
            timing: Timing { pulse: PULSE as u32, setup: 16, hold: 16, min_interval: 133 },
            cost: Cost::any_pulse([133; N]),
            fit: Fit::board(rate),
            horizon: 256_000,
            lead: 4_000,
            runs: u16::MAX,
        };
        let cycle = Cycle::new(time.clone(), pins, world, motors, clock, board);
        log.borrow_mut().clear();
        Rig { time, log, closed, cycle, begun: 0 }
    }

    pub fn start(&mut self) {
        self.begun = self.time.now.get();
        self.cycle.start().unwrap();
    }

    /// Serves the interrupt on time until `end` ticks of the timer.
    pub fn run_to(&mut self, end: u64) {
        while self.time.wake.get() <= end {
            self.time.now.set(self.time.wake.get().max(self.time.now.get()));
            self.cycle.on_compare();
        }
        self.time.now.set(end.max(self.time.now.get()));
    }

    /// Runs until `us` µs after the start, including the events that are due then.
    pub fn until(&mut self, us: u64) {
        self.run_to(self.begun + us * u64::from(HZ) / 1_000_000);
    }

    pub fn run_out(&mut self) {
        while self.cycle.is_running() {
            self.run_to(self.time.wake.get());
        }
    }

    /// Closes or opens the switches.
    pub fn close(&self, min: Axes, max: Axes) {
        self.closed.set(Switches { min, max });
    }

    pub fn position(&mut self, motor: u8) -> i64 {
        self.cycle.position(motor).unwrap()
    }

    /// The edges of an axis since the start: ticks of the timer.
    pub fn edges(&self, axis: u8) -> Vec<(u64, What)> {
        let log = self.log.borrow();
        log.iter()
            .filter(|e| e.1 == axis && e.0 >= self.begun)
            .map(|e| (e.0 - self.begun, e.2))
            .collect()
    }

    /// The rising edges of an axis since the start.
    pub fn rises(&self, axis: u8) -> Vec<u64> {
        self.edges(axis).iter().filter(|e| e.1 == What::Rise).map(|e| e.0).collect()
    }

    /// The steps of an axis by its edges alone: forward minus backward since the rig was made, for
    /// a motor that is not inverted.
    pub fn steps_of(&self, axis: u8) -> i64 {
        let (mut forward, mut steps, mut high) = (true, 0, false);
        for &(time, _, what) in self.log.borrow().iter().filter(|e| e.1 == axis) {
            match what {
                What::Dir(level) => forward = level,
                What::Rise => {
                    assert!(!high, "a pulse within a pulse at {time}");
                    high = true;
                    steps += if forward { 1 } else { -1 };
                }
                What::Fall => high = false,
                What::Enable(_) => {}
            }
        }
        assert!(!high, "STEP of axis {axis} is left high");
        steps
    }
}
