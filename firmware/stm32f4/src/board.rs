//! The board as data.

use stepwright::{Board, Cost, Rate};
use stepwright_controller::{AXES, board};

/// TIM2 without a prescaler: the processor's clock.
pub const RATE: Rate = Rate::of::<96_000_000>();

/// The board of the controller. Computed, not measured: a Cortex-M4 executes some 60 million
/// instructions a second at 96 MHz, with its flash's wait states. That is 7.7 times the speed at
/// which QEMU keeps these rates on the micro:bit; five times is used.
pub const BOARD: Board<AXES> =
    board(RATE, Cost::any_pulse([RATE.micros(16), RATE.micros(18), RATE.micros(20)]), 8_000);

/// Bits of port C: STEP of axis 1; the other axes follow: PC0 to PC2.
pub const STEP: u32 = 0;
/// DIR of axis 1, high for forward; the other axes follow: PC3 to PC5.
pub const DIR: u32 = 3;
/// The pin that enables the drivers: PC6.
pub const ENABLE: u32 = 6;
/// The switches of the axes, in a row: PC7 to PC9.
pub const SWITCHES: u32 = 7;
/// The emergency stop, to ground: PC10.
pub const EMERGENCY: u32 = 10;
/// The fault outputs of the drivers: PC11.
pub const FAULT: u32 = 11;
