//! The chips with a self-test.

use stepwright::profile::Fit;
use stepwright::{Board, Cost, Rate, Ticks, Timing};

/// A chip and the parameters of its test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chip {
    /// Its name, as in its line.
    pub name: &'static str,
    /// The rate of the timer that stamps the edges.
    pub rate: Rate,
    /// The highest ordered speed, in steps/s.
    pub top: u32,
    /// The highest ordered acceleration, in steps/s².
    pub accel: u32,
    /// The largest distance of an edge from the plan, in ticks of `rate`.
    pub bound: Ticks,
    /// Whether it has a second clock to measure `rate` by.
    pub has_second_clock: bool,
}

/// Raspberry Pi Pico: its PIO makes the steps, at most 1 µs from the plan, and a second one
/// captures them with a resolution of two ticks.
pub const RP2040: Chip = Chip {
    name: "rp2040",
    rate: Rate::of::<125_000_000>(),
    top: 250_000,
    accel: 10_000_000,
    bound: 125 + 2,
    has_second_clock: true,
};

/// The first micro:bit: an interrupt makes the steps and stamps them. At its highest speed a step
/// is late beyond half an interval and 1 µs ([`late_after`](stepwright::late_after)).
pub const NRF51: Chip = Chip {
    name: "nrf51",
    rate: Rate::of::<16_000_000>(),
    top: 10_000,
    accel: 100_000,
    bound: 816,
    has_second_clock: false,
};

/// ST's Nucleo-F411RE, like the micro:bit.
pub const STM32F411: Chip = Chip {
    name: "stm32f411",
    rate: Rate::of::<96_000_000>(),
    top: 50_000,
    accel: 1_000_000,
    bound: 1_056,
    has_second_clock: false,
};

/// All chips.
pub const CHIPS: [Chip; 3] = [RP2040, NRF51, STM32F411];

impl Chip {
    /// The chip of this name.
    pub fn named(name: &str) -> Option<&'static Chip> {
        static ALL: [Chip; 3] = CHIPS;
        ALL.iter().find(|chip| chip.name == name)
    }

    /// The board for which its orders are planned: one axis moves at a time.
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
