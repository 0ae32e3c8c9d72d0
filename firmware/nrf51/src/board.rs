//! The board as data.

use stepwright::{Board, Cost, Rate};
use stepwright_controller::{AXES, CyclePins, StreamBoard, board};
use stepwright_protocol::flash_text;

/// TIMER0 without a prescaler.
pub const RATE: Rate = Rate::of::<16_000_000>();

/// The board of the controller: the rates that QEMU keeps without a late step at 7.8 million
/// instructions a second, which is the speed of the chip (`firmware/qemu/tests/edges.rs`).
pub const BOARD: Board<AXES> =
    board(RATE, Cost::any_pulse([RATE.micros(80), RATE.micros(90), RATE.micros(100)]), 1_600);

/// The player of streams: an axis's step interrupt takes 100 instructions.
pub const STREAM: StreamBoard =
    StreamBoard { name: flash_text!("micro:bit"), rate: RATE, least: RATE.micros(13) };

/// Bits of the port: STEP of axis 1; the other axes follow. On the micro:bit's edge P15, P14 and
/// P13.
pub const STEP: u32 = 21;
/// DIR of axis 1, high for forward; the other axes follow: P2, P1 and P0.
pub const DIR: u32 = 1;
/// The pin that enables the drivers: P16.
pub const ENABLE: u32 = 16;
/// The switches of the axes: P8, P12 and P19.
pub const SWITCHES: [u32; AXES] = [18, 20, 0];
/// The emergency stop, to ground: button A.
pub const EMERGENCY: u32 = 17;
/// The fault outputs of the drivers: P20.
pub const FAULT: u32 = 30;

/// The pins of motor cycles.
pub const CYCLE_PINS: [CyclePins; AXES] = {
    let mut pins = [CyclePins { step: 0, direction: 0, enable: ENABLE as u8, switch: 0 }; AXES];
    let mut axis = 0;
    while axis < AXES {
        pins[axis].step = STEP as u8 + axis as u8;
        pins[axis].direction = DIR as u8 + axis as u8;
        pins[axis].switch = SWITCHES[axis] as u8;
        axis += 1;
    }
    pins
};
