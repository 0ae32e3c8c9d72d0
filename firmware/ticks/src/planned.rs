//! Orders as a board plans them: small numbers, runs, entries. The entries are those that its step
//! interrupt would play, event by event.

use stepwright::profile::Ramp;
use stepwright::{Board, Cost, Order, Rate, Travel as Way};
use stepwright_selftest::{Crc32, STEP, groups};

use crate::{Law, Sum, Travel};

/// A trapezoid as a board plans it.
pub const BOARD: Law = Law { name: "board", place: 8, sum: |t| ordered(t, false) };

/// An S-curve as a board plans it.
pub const BOARD_JERK: Law = Law { name: "board-jerk", place: 9, sum: |t| ordered(t, true) };

/// A timer of 16 MHz, steps of 20 µs, and no limit of runs.
const UNO: Board<1> = Board {
    cost: Cost::any_pulse([320]),
    runs: u16::MAX,
    ..Board::unmeasured(Rate::of::<16_000_000>())
};

/// The entries of an order, in the form that an AVR's interrupt plays and every chip can make.
fn ordered(travel: &Travel, jerk: bool) -> Option<Sum> {
    let order = Order {
        start: travel.start,
        top: travel.top,
        up: Ramp::Accel(travel.accel),
        down: Ramp::Accel(travel.decel),
        jerk: jerk.then_some(travel.jerk),
        travel: Way::By(travel.pulses as i32),
    };
    let mut crc = Crc32::new();
    let mut steps = 0u32;
    let taken = groups(UNO, order, |pins, events, wait| {
        [u32::from(pins), events, wait].into_iter().for_each(|word| crc.add(word));
        if pins & STEP != 0 {
            steps = steps.wrapping_add(events);
        }
    });
    taken.then(|| Sum { pulses: steps, crc: crc.end() })
}
