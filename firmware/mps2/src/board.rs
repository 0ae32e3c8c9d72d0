//! The board as data.

use stepwright::{Board, Cost, Rate};
use stepwright_controller::{AXES, board};

/// The dual timer without a prescaler.
pub const RATE: Rate = Rate::of::<25_000_000>();

/// The board of the controller: the rates that QEMU keeps without a late step at 7.8 million
/// instructions a second (`firmware/qemu/tests/edges.rs`).
pub const BOARD: Board<AXES> =
    board(RATE, Cost::any_pulse([RATE.micros(80), RATE.micros(90), RATE.micros(100)]), 1_600);

/// The port, which QEMU's board lacks: 128 words of RAM that nothing reads. A store to word N
/// raises the pins whose bits N has; a store to word N of [`CLEAR`] lowers them.
pub const SET: usize = 0x2100_0000;
/// See [`SET`].
pub const CLEAR: usize = SET + PORT_SIZE;
/// The bytes of each.
pub const PORT_SIZE: usize = 0x200;

/// Bits of the port: STEP of axis 1; the other axes follow.
pub const STEP: u32 = 0;
/// DIR of axis 1, high for forward; the other axes follow.
pub const DIR: u32 = 3;
/// The pin that enables the drivers.
pub const ENABLE: u32 = 6;
