//! Orders as a board plans them: small numbers, runs, entries. What its step interrupt would play,
//! event by event.

use stepwright::entry::Wiring;
use stepwright::profile::Ramp;
use stepwright::queue::{Next, Queue};
use stepwright::{
    Axis, Board, Control, Cost, Order, OrderedMotors, Playing, Rate, Report, Timing, Travel as Way,
};

use crate::{Crc32, Law, Sum, Travel};

/// The pin of STEP in an entry, and that of DIR.
const STEP: u8 = 1;
const DIR: u8 = 2;

/// A trapezoid as a board plans it.
pub const BOARD: Law = Law { name: "board", place: 8, sum: |t| ordered(t, false) };

/// An S-curve as a board plans it.
pub const BOARD_JERK: Law = Law { name: "board-jerk", place: 9, sum: |t| ordered(t, true) };

/// A timer of 16 MHz, steps of 20 µs, and as many runs as there are.
const UNO: Board<1> = Board {
    cost: Cost::any_pulse([320]),
    runs: u16::MAX,
    ..Board::unmeasured(Rate::of::<16_000_000>())
};

/// An engine that takes no part: whoever has the queue's other end is one.
struct Silent;

impl Control for Silent {
    fn start(&mut self, _: u8) {}
    fn kill(&mut self, _: u8) {}
    fn report(&self, _: u8) -> Report {
        Report { position: 0, idle: true, forward: true }
    }
    fn playing(&mut self, _: u8) -> Playing {
        Playing::Unknown
    }
    fn set_position(&mut self, _: u8, _: i64) {}
    fn set_timing(&mut self, _: Timing) {}
    fn late(&self) -> u32 {
        0
    }
    fn clear_late(&mut self) {}
}

/// The entries of an order, in the form that an AVR's interrupt plays and every chip can make: of each
/// group its pins, its events, and the wait after each in 2⁻¹⁶ ticks.
fn ordered(travel: &Travel, jerk: bool) -> Option<Sum> {
    let mut queue = Queue::<8>::new();
    let (feed, mut end) = queue.split_as(Wiring::new(STEP, DIR));
    let mut motors = OrderedMotors::<Silent, 1, 8>::new(Silent, [feed], UNO);
    let order = Order {
        start: travel.start,
        top: travel.top,
        up: Ramp::Accel(travel.accel),
        down: Ramp::Accel(travel.decel),
        jerk: jerk.then_some(travel.jerk),
        travel: Way::By(travel.pulses as i32),
    };
    motors.start([(Axis::<1>::at::<0>(), order)]).ok()?;
    let entries = core::iter::from_fn(|| {
        loop {
            match end.take() {
                Next::Entry(entry) => return Some(entry),
                Next::Late if motors.plan() => {}
                Next::Late | Next::End => return None,
            }
        }
    });
    let mut crc = Crc32::new();
    let mut steps = 0u32;
    for (pins, events, wait) in entries.flat_map(|entry| entry.groups()) {
        [u32::from(pins), events, wait].into_iter().for_each(|word| crc.add(word));
        if pins & STEP != 0 {
            steps = steps.wrapping_add(events);
        }
    }
    Some(Sum { pulses: steps, crc: crc.end() })
}
