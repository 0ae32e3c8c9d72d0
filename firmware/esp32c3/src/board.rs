//! The board as data.

use stepwright::{Board, Cost, Rate};
use stepwright_controller::{AXES, board};

/// SYSTIMER.
pub const RATE: Rate = Rate::of::<16_000_000>();

/// The board of the controller. Estimated, not measured: SYSTIMER is read over a slow bus, and code
/// comes from flash through a cache.
pub const BOARD: Board<AXES> =
    board(RATE, Cost::any_pulse([RATE.micros(40), RATE.micros(45), RATE.micros(50)]), 3_200);

/// GPIO: STEP of axis 1; the other axes follow.
pub const STEP: u32 = 4;
/// DIR of axis 1, high for forward; the other axes follow. The ROM samples GPIO 2 at a reset; a
/// driver's input does not disturb it.
pub const DIR: u32 = 0;
/// The pin that enables the drivers.
pub const ENABLE: u32 = 7;
/// The emergency stop, to ground.
pub const EMERGENCY: u32 = 10;
