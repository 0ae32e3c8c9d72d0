//! The description of a simulated board.

use stepwright::drive::Sequence;
use stepwright::profile::Fit;
use stepwright::{Board, Cost, Rate, Ticks, Timing};

use crate::AXES;
use crate::edge::Pin;

/// A board as data: what a real board has in its silicon and its settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Description {
    /// The number of connected axes, 1 … 3.
    pub axes: u8,
    /// The timer, the drivers' times and the cost of a step.
    pub board: Board<AXES>,
    /// Ticks between possible matches of an axis' compare register, a power of two: 1, or more on a timer with
    /// a prescaler.
    pub grid: [Ticks; AXES],
    /// Whether the step interrupts are an AVR's in assembly, which need time between two entries: see
    /// `stepwright::entry::Wiring`.
    pub assembly: bool,
    /// Bits per second of the serial line; a byte has ten.
    pub baud: u32,
    /// The table of a motor on coils; `None` for STEP and DIR.
    pub coils: [Option<Sequence>; AXES],
}

/// The timer of an Uno.
const UNO: Rate = match Rate::from_hz(16_000_000) {
    Ok(rate) => rate,
    Err(_) => panic!("16 MHz is a rate"),
};

impl Description {
    /// An Arduino Uno: 16 MHz, 16 bits, three axes, with the costs of its firmware.
    pub fn uno() -> Description {
        let (ticks, longer, shortest) = ([125, 184, 251], [1_250, 1_700, 4_400], [125, 280, 560]);
        let cost = Cost { ticks, pulse: 45, longer, shortest };
        let uno = Description::at(UNO, cost);
        // The third axis is on timer 2, which counts every eighth cycle.
        let board = Board { runs: 2_900, ..uno.board };
        Description { board, grid: [1, 1, 8], assembly: true, ..uno }
    }

    /// A board with a timer of `rate` and these costs of a step; pulses and direction times are the Uno's.
    pub fn at(rate: Rate, cost: Cost<AXES>) -> Description {
        let (pulse, setup, hold) = (rate.nanos(2_000), rate.nanos(1_000), rate.nanos(1_000));
        let mut board = Board {
            rate,
            timing: Timing { pulse, setup, hold, min_interval: 0 },
            cost,
            runs: u16::MAX,
            fit: Fit::board(rate),
            horizon: rate.micros(16_000),
            lead: rate.micros(250),
        };
        board.set_drivers(pulse, setup, hold);
        let (axes, grid, coils) = (AXES as u8, [1; AXES], [None; AXES]);
        Description { axes, board, grid, assembly: false, baud: 115_200, coils }
    }

    /// As [`at`](Description::at), for a board on which a step costs nothing but its pulse: this many ticks
    /// while 1, 2 or 3 axes move, and more with pulses of 3 to 20 µs.
    pub fn quick(rate: Rate, ticks: [Ticks; AXES]) -> Description {
        // A step waits for the pulse p of another axis, and catches up by the part of its interval I above 2p,
        // a pulse and a pause. Beside one axis, I ≥ 2p leaves I/2 for the wait; at I = 2p the admitted rates
        // are used up, and the other axis never steps. Beside two axes a step may wait twice in a row, and has
        // caught up I − 2p in between: 4p − I ≤ I/2.
        let longer = [20, 40, 60].map(|micros| rate.micros(micros));
        let [one, two, three] = ticks;
        let longer = [one.max(longer[0]), two.max(longer[1]), three.max(longer[2])];
        let shortest = [0; AXES];
        Description::at(rate, Cost { ticks, pulse: rate.nanos(2_000), longer, shortest })
    }

    /// The pins that move the axes: axis, pin, and the level at power-up, if it is known before an order.
    pub fn pins(&self) -> impl Iterator<Item = (u8, Pin, Option<bool>)> + use<> {
        let axes = (0..self.axes).zip(self.coils);
        axes.flat_map(|(axis, coils)| {
            let lines = coils.map_or(0, |sequence| sequence.lines());
            let line = move |line| {
                let levels = coils.map_or(0, |sequence| sequence.levels(0));
                (axis, Pin::Coil(line), Some(levels >> line & 1 != 0))
            };
            let pulse = [(axis, Pin::Step, Some(false)), (axis, Pin::Direction, None)];
            let pulse = pulse.into_iter().filter(move |_| coils.is_none());
            pulse.chain((0..lines).map(line))
        })
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
