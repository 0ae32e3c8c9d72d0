//! The board as data.

use stepwright::profile::Fit;
use stepwright::{Board, Cost, Rate, Ticks, Timing};
use stepwright_controller::{AXES, StreamBoard};
use stepwright_protocol::flash_text;

/// The processor's clock, which is also the PIO's.
pub const RATE: Rate = Rate::of::<125_000_000>();

/// The shortest interval of an axis, in ticks: 250,000 steps/s. The PIO is capable of more, but a
/// group of 64 steps has to last longer than the interrupts of four axes.
pub const LEAST: Ticks = 500;

/// The largest deviation of a step from the planner's time, in ticks: 1 µs.
pub const BOUND: Ticks = RATE.micros(1);

/// The timer's rate for streams: an eighth of the clock, because a record waits for less than 2¹⁶
/// ticks.
pub const STREAM_RATE: Rate = Rate::of::<15_625_000>();

/// The player of streams. It plays up to 250,000 steps/s.
pub const STREAM: StreamBoard =
    StreamBoard { name: flash_text!("pico"), rate: STREAM_RATE, least: STREAM_RATE.micros(4) };

/// The board for streams: times in the ticks of that timer, pulses of 2 µs.
pub const STREAM_BOARD: Board<AXES> = {
    let mut board = board();
    let micro = STREAM_RATE.nanos(1_000);
    board.rate = STREAM_RATE;
    board.timing =
        Timing { pulse: 2 * micro, setup: micro, hold: micro, min_interval: STREAM.least };
    board
};

/// The state machines of a PIO, and so the axes of a program.
pub const MACHINES: usize = 4;

/// STEP of axis 0; the other axes follow: GPIO 2 to 5.
pub const STEP: u32 = 2;
/// DIR of axis 0, high for forward; the other axes follow: GPIO 6 to 9.
pub const DIR: u32 = 6;
/// The pin that enables the drivers.
pub const ENABLE: u32 = 10;
/// The switches of the controller's axes.
pub const SWITCHES: [u32; 3] = [11, 12, 13];
/// The fault outputs of the drivers.
pub const FAULT: u32 = 14;
/// The emergency stop, to ground.
pub const EMERGENCY: u32 = 15;
/// The laser for streams.
pub const LASER: u32 = 16;
/// The serial line: transmit and receive.
pub const LINE: [u32; 2] = [0, 1];

/// The board with pulses of 1 µs.
pub const fn board<const N: usize>() -> Board<N> {
    let (pulse, side) = (RATE.micros(1), RATE.micros(1));
    Board {
        rate: RATE,
        timing: Timing { pulse, setup: side, hold: side, min_interval: LEAST },
        cost: Cost::independent(LEAST),
        // Four axes that ramp to 250,000 steps/s at once need 15,300 of these runs, and no queue
        // runs dry.
        runs: 16_400,
        fit: Fit::board(RATE),
        horizon: RATE.micros(16_000),
        lead: RATE.micros(250),
    }
}
