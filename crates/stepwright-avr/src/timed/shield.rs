//! The motor shield's pins, and those of a second shield whose brake lines are cut.
//!
//! | | Uno | Mega | |
//! | --- | --- | --- | --- |
//! | D12, D13 | PB4, PB5 | PB6, PB7 | directions of bridges A and B |
//! | D3, D11 | PD3, PB3 | PE5, PB5 | their enables |
//! | D9, D8 | PB1, PB0 | PH6, PH5 | their brakes, or a second shield's directions |
//!
//! Source: the Arduino driver, sections 3 and 5.

use core::sync::atomic::{AtomicU8, Ordering};

use stepwright::drive::{Port, Sequence, sequence::SHIELD};

use super::port::{Pins, PortB};

#[cfg(feature = "uno")]
use super::port::PortB as PortOfD9;
#[cfg(feature = "uno")]
use super::port::PortD as PortOfD3;
#[cfg(feature = "mega")]
use super::port::PortE as PortOfD3;
#[cfg(feature = "mega")]
use super::port::PortH as PortOfD9;

/// The bits of D12 and D13 on port B.
pub const DIRECTION: [u8; 2] = if cfg!(feature = "mega") { [6, 7] } else { [4, 5] };
/// The bits of D9 and D8, on port H of the Mega.
pub const DIRECTION_2: [u8; 2] = if cfg!(feature = "mega") { [6, 5] } else { [1, 0] };
/// D11: enable B.
const ENABLE_B: u8 = if cfg!(feature = "mega") { 1 << 5 } else { 1 << 3 };
/// D3: enable A.
const ENABLE_A: u8 = if cfg!(feature = "mega") { 1 << 5 } else { 1 << 3 };

/// The bits of two lines as a mask.
const fn mask_of([a, b]: [u8; 2]) -> u8 {
    1 << a | 1 << b
}

/// Two direction lines as a motor's table and its mask.
pub fn lines(bits: [u8; 2]) -> (Sequence, u8) {
    (SHIELD.on_bits(&bits), mask_of(bits))
}

/// Makes the shields' pins outputs, all low: enables off, brakes off.
pub fn pins() {
    PortB.drive(mask_of(DIRECTION) | ENABLE_B);
    PortOfD3.drive(ENABLE_A);
    PortOfD9.drive(mask_of(DIRECTION_2));
}

/// The motors whose drivers are on: stacked shields share their enables.
static DRIVING: AtomicU8 = AtomicU8::new(0);

/// Switches the drivers of one motor on or off. `bit` is the motor's own; 0 for a motor on no
/// shield.
pub fn power(bit: u8, on: bool) {
    if bit == 0 {
        return;
    }
    let before = DRIVING.load(Ordering::Relaxed);
    let now = if on { before | bit } else { before & !bit };
    DRIVING.store(now, Ordering::Relaxed);
    let levels = if now != 0 { 0xFF } else { 0 };
    PortB.write(ENABLE_B, levels);
    PortOfD3.write(ENABLE_A, levels);
}
