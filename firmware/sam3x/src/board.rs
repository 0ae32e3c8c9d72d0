//! The board as data.

use stepwright::{Board, Cost, Rate};
use stepwright_controller::{AXES, board};

/// A timer channel at half the processor's clock.
pub const RATE: Rate = Rate::of::<42_000_000>();

/// The board of the controller. Computed, not measured: a Cortex-M3 executes some 50 million
/// instructions a second at 84 MHz, with its flash's wait states. That is 6.4 times the speed at
/// which QEMU keeps these rates on the micro:bit; four times is used.
pub const BOARD: Board<AXES> =
    board(RATE, Cost::any_pulse([RATE.micros(20), RATE.micros(23), RATE.micros(25)]), 6_400);

/// Bits of port C: STEP of axis 1; the other axes follow. On the Due pins 33, 34 and 35.
pub const STEP: u32 = 1;
/// DIR of axis 1, high for forward; the other axes follow: pins 36, 37 and 38.
pub const DIR: u32 = 4;
/// The pin that enables the drivers: 39.
pub const ENABLE: u32 = 7;
/// The switches of the axes, in a row: pins 51, 50 and 49.
pub const SWITCHES: u32 = 12;
/// The emergency stop, to ground: pin 48.
pub const EMERGENCY: u32 = 15;
/// The fault outputs of the drivers: pin 47.
pub const FAULT: u32 = 16;
