//! The drives of the examples `drives_planned` and `drives_cycles`, and their pins.

use stepwright::drive::Sequence;
use stepwright::drive::sequence::{
    BRIDGE_HALF, L6219_FULL, L6219_HALF, L6219_QUARTER, SHIELD, UNIPOLAR_FULL, UNIPOLAR_HALF,
};
use stepwright_avr::drives::AnyDrive;

/// The tables, each with its lines on a port.
pub const WINDINGS: [(Sequence, u8); 7] = [
    (SHIELD, 0b11),
    (BRIDGE_HALF, 0b1111),
    (UNIPOLAR_FULL, 0b1111),
    (UNIPOLAR_HALF, 0b1111),
    (L6219_FULL, 0b11_1111),
    (L6219_HALF, 0b11_1111),
    (L6219_QUARTER, 0b11_1111),
];

#[cfg(feature = "mega")]
const PORTS: (u8, u8, u8, u8) = (b'C', 1, 2, b'A');
#[cfg(feature = "uno")]
const PORTS: (u8, u8, u8, u8) = (b'D', 2, 5, b'B');

/// D2 and D5 of an Uno, D36 and D35 of a Mega.
pub fn step_dir() -> Option<AnyDrive> {
    let (port, step, direction, _) = PORTS;
    AnyDrive::step_dir(port, step, direction)
}

/// D8 to D13 of an Uno, D22 to D27 of a Mega.
pub fn windings((sequence, mask): (Sequence, u8)) -> Option<AnyDrive> {
    AnyDrive::windings(PORTS.3, sequence, mask)
}
