//! The chips that have a self-test.

use stepwright::profile::Fit;
use stepwright::{Board, Cost, Rate, Ticks, Timing};

/// A chip, and what its test asks of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chip {
    /// As in its line.
    pub name: &'static str,
    /// Of the timer that edges are counted on.
    pub rate: Rate,
    /// The highest speed that is ordered, in steps/s.
    pub top: u32,
    /// The highest acceleration that is ordered, in steps/s².
    pub accel: u32,
    /// How far an edge may be from the plan, in ticks of `rate`.
    pub bound: Ticks,
    /// Whether it has a second clock to measure that of `rate` by.
    pub has_second_clock: bool,
}

/// Raspberry Pi Pico: its PIO makes the steps, 1 µs from the plan at most, and another one captures them to
/// two ticks.
pub const RP2040: Chip = Chip {
    name: "rp2040",
    rate: Rate::of::<125_000_000>(),
    top: 250_000,
    accel: 10_000_000,
    bound: 125 + 2,
    has_second_clock: true,
};

/// The first micro:bit: an interrupt makes the steps, and stamps them. At its highest speed it is late beyond
/// half an interval and 1 µs ([`late_after`](stepwright::late_after)).
pub const NRF51: Chip = Chip {
    name: "nrf51",
    rate: Rate::of::<16_000_000>(),
    top: 10_000,
    accel: 100_000,
    bound: 816,
    has_second_clock: false,
};

/// ST's Nucleo-F411RE: likewise.
pub const STM32F411: Chip = Chip {
    name: "stm32f411",
    rate: Rate::of::<96_000_000>(),
    top: 50_000,
    accel: 1_000_000,
    bound: 1_056,
    has_second_clock: false,
};

/// All of them.
pub const CHIPS: [Chip; 3] = [RP2040, NRF51, STM32F411];

impl Chip {
    /// The chip of this name.
    pub fn named(name: &str) -> Option<&'static Chip> {
        static ALL: [Chip; 3] = CHIPS;
        ALL.iter().find(|chip| chip.name == name)
    }

    /// The board that its orders are planned for: one axis moves at a time.
    pub const fn board<const N: usize>(&self) -> Board<N> {
        let rate = self.rate;
        let (pulse, side) = (rate.nanos(1_000), rate.nanos(1_000));
        let least = match rate.hz().checked_div(self.top) {
            Some(least) => least,
            None => Ticks::MAX,
        };
        Board {
            rate,
            timing: Timing { pulse, setup: side, hold: side, min_interval: least },
            cost: Cost::independent(least),
            runs: u16::MAX,
            fit: Fit::board(rate),
            horizon: rate.micros(16_000),
            lead: rate.micros(250),
        }
    }
}
