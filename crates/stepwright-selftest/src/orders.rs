//! The orders and their plan.

use stepwright::entry::Wiring;
use stepwright::profile::Ramp;
use stepwright::queue::{Next, Queue};
use stepwright::{
    Accel, Axis, Board, Control, Jerk, Order, OrderedMotors, Playing, Report, Speed, Timing, Travel,
};

use crate::{Chip, Crc32, Luck};

/// The number of orders of a test.
pub const ORDERS: u32 = 16;

/// The most pulses of an order.
pub const MOST_PULSES: u32 = 1_023;

/// The [`Luck`] series of the orders, which no law of `firmware/ticks` uses.
const SERIES: u32 = 29;

/// The pins STEP and DIR in a group.
pub const STEP: u8 = 1;
const DIR: u8 = 2;

impl Chip {
    /// An order of its test, from 0 to [`ORDERS`] − 1: 4 to 1,023 pulses, up to between 3/32 and
    /// all of the chip's top speed. Every third has a limit of jerk, and lower accelerations, as
    /// its planning takes four times as long; every second goes backward.
    pub fn order(&self, number: u32) -> Order {
        let mut luck = Luck::of(SERIES, number);
        let curved = number % 3 == 2;
        let pulses = luck.about(2, 10);
        let top = self.top >> luck.below(4);
        let top = top.wrapping_sub(luck.below(top / 4));
        let mut accel = || match curved {
            true => self.accel >> 5 >> luck.below(3),
            false => self.accel >> luck.below(6),
        };
        let (up, down) = (accel(), accel());
        let back = number % 2 == 1;
        Order {
            start: Speed::ZERO,
            top: Speed::from_steps(top).unwrap_or(Speed::MAX),
            up: Ramp::Accel(Accel::clamped(up)),
            down: Ramp::Accel(Accel::clamped(down)),
            // The acceleration builds up in 1/64 s.
            jerk: curved.then(|| Jerk::clamped(up.max(down).saturating_mul(64))),
            travel: Travel::By(if back { -(pulses as i32) } else { pulses as i32 }),
        }
    }
}

/// An engine that does nothing: the reader of the queue's other end takes its place.
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

/// Plans one order of an axis. Calls `group` with the parts of its entries in a form that every
/// chip can make: pins, events, and the wait after each in 2⁻¹⁶ ticks. Returns false if the order
/// is refused.
pub fn groups(board: Board<1>, order: Order, mut group: impl FnMut(u8, u32, u32)) -> bool {
    let mut queue = Queue::<8>::new();
    let (feed, mut end) = queue.split_as(Wiring::new(STEP, DIR));
    let mut motors = OrderedMotors::<Silent, 1, 8>::new(Silent, [feed], board);
    if motors.start([(Axis::<1>::at::<0>(), order)]).is_err() {
        return false;
    }
    loop {
        match end.take() {
            Next::Entry(entry) => {
                entry.groups().for_each(|(pins, events, wait)| group(pins, events, wait));
            }
            Next::Late if motors.plan() => {}
            Next::Late | Next::End => return true,
        }
    }
}

/// Plans an order of a chip. Adds its [`groups`] to `sum`, and calls `edge` with the time of each
/// pulse, in 2⁻¹⁶ ticks from the first wait. Returns false if the order is refused.
pub fn plan(chip: &Chip, number: u32, sum: &mut Crc32, mut edge: impl FnMut(u64)) -> bool {
    let mut time = 0u64;
    groups(chip.board(), chip.order(number), |pins, events, wait| {
        [u32::from(pins), events, wait].into_iter().for_each(|word| sum.add(word));
        for _ in 0..events {
            if pins & STEP != 0 {
                edge(time);
            }
            time = time.wrapping_add(wait.into());
        }
    })
}
