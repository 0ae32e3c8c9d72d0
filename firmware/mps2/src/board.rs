//! The board as data.

use stepwright::{Board, Cost, Rate};
use stepwright_controller::{AXES, board};

/// The dual timer without a prescaler.
pub const RATE: Rate = Rate::of::<25_000_000>();

/// The board of the controller: what QEMU keeps without a late step at 7.8 million instructions a
/// second (`firmware/qemu/tests/edges.rs`).
pub const BOARD: Board<AXES> =
    board(RATE, Cost::any_pulse([RATE.micros(80), RATE.micros(90), RATE.micros(100)]), 1_600);

/// The port, which QEMU's board has not: 128 words of RAM that nobody reads. A store to word N raises the
/// pins whose bits N has; one to word N of [`CLEAR`] lowers them.
pub const SET: usize = 0x2100_0000;
/// See [`SET`].
pub const CLEAR: usize = SET + PORT_SIZE;
/// Bytes of each.
pub const PORT_SIZE: usize = 0x200;

/// Bits of the port: STEP of axis 1, of the others in a row behind it.
pub const STEP: u32 = 0;
/// Likewise DIR, high for forward.
pub const DIR: u32 = 3;
/// The pin that enables the drivers.
pub const ENABLE: u32 = 6;
