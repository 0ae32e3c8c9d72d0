//! The board as data.

use stepwright::{Board, Cost, Rate};
use stepwright_controller::{AXES, board};

/// SYSTIMER.
pub const RATE: Rate = Rate::of::<16_000_000>();

/// The board of the controller. Guessed, not measured: SYSTIMER is read over a slow bus, and code comes
/// from flash through a cache.
pub const BOARD: Board<AXES> =
    board(RATE, Cost::any_pulse([RATE.micros(40), RATE.micros(45), RATE.micros(50)]), 3_200);

/// GPIO: STEP of axis 1, of the others in a row behind it.
pub const STEP: u32 = 4;
/// Likewise DIR, high for forward. The ROM looks at GPIO 2 at a reset, which a driver's input leaves alone.
pub const DIR: u32 = 0;
/// The pin that enables the drivers.
pub const ENABLE: u32 = 7;
/// The emergency stop, to ground.
pub const EMERGENCY: u32 = 10;
