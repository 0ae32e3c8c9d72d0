//! What kind of board is simulated.

use stepwright::profile::Fit;
use stepwright::{Board, Rate, Ticks, Timing};

use crate::AXES;

/// A board as data: what a real one has in silicon and in its settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Description {
    /// How many of the axes are connected, 1 … 3.
    pub axes: u8,
    /// Timer, driver times and the cost of a step.
    pub board: Board<AXES>,
    /// Bits per second of the serial line; a byte is ten.
    pub baud: u32,
}

impl Description {
    /// An Arduino Uno: 16 MHz, 16 bits, three axes; the costs are those of
    /// its firmware.
    pub fn uno() -> Description {
        Description::at(Rate::from_hz(16_000_000).unwrap_or(Rate::MHZ), [140, 213, 251])
    }

    /// A board with a timer of `rate` and `cost` ticks per step while 1, 2 or
    /// 3 axes move; pulses and direction times as the Uno's.
    pub fn at(rate: Rate, cost: [Ticks; AXES]) -> Description {
        let pulse = rate.nanos(2_000);
        let timing = Timing {
            pulse,
            setup: rate.nanos(1_000),
            hold: rate.nanos(1_000),
            min_interval: cost[0].max(2 * pulse),
        };
        Description {
            axes: AXES as u8,
            board: Board {
                rate,
                timing,
                cost,
                fit: Fit::board(rate),
                horizon: rate.micros(16_000),
                lead: rate.micros(250),
            },
            baud: 115_200,
        }
    }

    /// Ticks that a byte takes on the serial line.
    pub fn byte_time(&self) -> u64 {
        u64::from(self.board.rate.hz()) * 10 / u64::from(self.baud.max(1))
    }
}

impl Default for Description {
    fn default() -> Self {
        Description::uno()
    }
}
