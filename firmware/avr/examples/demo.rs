//! The demo of Austin's article, 1,000 steps there and back by the published listing, on several
//! drives in turn: step and direction, an L6219 in full, half and quarter steps, a unipolar motor,
//! and two bridges of which only the directions are switched, as on a motor shield.
//!
//! | | STEP, DIR | windings |
//! | --- | --- | --- |
//! | Uno | D2, D5 | D8 to D13 (port B) |
//! | Mega | D36, D35 (port C) | D22 to D27 (port A) |
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright::drive::Sequence;
use stepwright::drive::sequence::{L6219_FULL, L6219_HALF, L6219_QUARTER, SHIELD, UNIPOLAR_HALF};
use stepwright_austin::Fixed;
use stepwright_avr::drives::AnyDrive;

stepwright_avr::asked_motor!(
    /// The motor on timer 1.
    mod motor, Fixed, AnyDrive, Timer1, TIMER1_COMPA
);

/// The steps, the first delay and the shortest delay, in µs.
const DEMO: (u32, u32, u32) = (1_000, 50_000, 2_500);

#[cfg(feature = "mega")]
const STEP_DIR: (u8, u8, u8) = (b'C', 1, 2);
#[cfg(feature = "uno")]
const STEP_DIR: (u8, u8, u8) = (b'D', 2, 5);
#[cfg(feature = "mega")]
const WINDINGS: u8 = b'A';
#[cfg(feature = "uno")]
const WINDINGS: u8 = b'B';

const TABLES: [(Sequence, u8); 5] = [
    (L6219_FULL, 0b11_1111),
    (L6219_HALF, 0b11_1111),
    (L6219_QUARTER, 0b11_1111),
    (UNIPOLAR_HALF, 0b1111),
    (SHIELD, 0b11),
];

fn windings((sequence, mask): (Sequence, u8)) -> Option<AnyDrive> {
    AnyDrive::windings(WINDINGS, sequence, mask)
}

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once, with interrupts off.
    let mut motor = unsafe { motor::take() };
    // SAFETY: everything that an interrupt uses is set up.
    unsafe { avr_device::interrupt::enable() };
    let (port, step, direction) = STEP_DIR;
    let step_dir = AnyDrive::step_dir(port, step, direction);
    let drives = [step_dir].into_iter().chain(TABLES.into_iter().map(windings));
    for drive in drives.flatten() {
        motor.wire(drive);
        let (steps, first, shortest) = DEMO;
        // A law without pulses does not move the motor.
        for (pulses, forward) in [(steps, true), (steps, false), (0, true)] {
            motor.play(Fixed::new(pulses, first, shortest), forward);
            while motor.is_moving() {}
        }
    }
    loop {}
}
