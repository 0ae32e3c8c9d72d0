//! The board as data.

use stepwright::{Board, Cost, Rate};
use stepwright_controller::{AXES, CyclePins, StreamBoard, board};
use stepwright_protocol::flash_text;

/// `mtime`.
pub const RATE: Rate = Rate::of::<10_000_000>();

/// The board of the controller: the rates that QEMU keeps without a late step at 7.8 million
/// instructions a second (`firmware/qemu/tests/edges.rs`).
pub const BOARD: Board<AXES> =
    board(RATE, Cost::any_pulse([RATE.micros(80), RATE.micros(90), RATE.micros(100)]), 1_600);

/// The player of streams: an axis's step interrupt takes 100 instructions.
pub const STREAM: StreamBoard =
    StreamBoard { name: flash_text!("virt"), rate: RATE, least: RATE.micros(13) };

/// The port, which `virt` lacks: 128 words of RAM that nothing reads. A store to word N raises the
/// pins whose bits N has; a store to word N of [`CLEAR`] lowers them. So the address alone shows
/// the change, whatever is stored.
pub const SET: usize = 0x8020_0000;
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

/// The pins of motor cycles. There are no switches.
pub const CYCLE_PINS: [CyclePins; AXES] = {
    let mut pins = [CyclePins { step: 0, direction: 0, enable: ENABLE as u8, switch: 255 }; AXES];
    let mut axis = 0;
    while axis < AXES {
        pins[axis].step = STEP as u8 + axis as u8;
        pins[axis].direction = DIR as u8 + axis as u8;
        axis += 1;
    }
    pins
};
