//! The demo of Austin's article, 1,000 steps there and back by the published listing, on one
//! drive after the other: step and direction, an L6219 in full, half and quarter steps, a
//! unipolar motor, and two bridges whose directions alone are switched, as a motor shield's are.
//!
//! | | STEP, DIR | windings |
//! | --- | --- | --- |
//! | Uno | D2, D5 | D8 to D13 (port B) |
//! | Mega | D36, D35 (port C) | D22 to D27 (port A) |
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright::drive::sequence::{L6219_FULL, L6219_HALF, L6219_QUARTER, SHIELD, UNIPOLAR_HALF};
use stepwright::drive::{Axes, Coils, Drive, PortDrive, Sequence};
use stepwright_austin::Fixed;
use stepwright_avr::asked::Output;
use stepwright_avr::timed::{AnyPort, Pins};

stepwright_avr::asked_motor!(
    /// The motor on timer 1.
    mod motor, Fixed, Wired, Timer1, TIMER1_COMPA
);

/// Steps, the first delay and the shortest, in µs.
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

/// What the motor is on.
enum Wired {
    StepDir(PortDrive<AnyPort>),
    Coils(Coils<AnyPort>),
}

impl Drive for Wired {
    #[inline(always)]
    fn begin(&mut self, axes: Axes) {
        match self {
            Wired::StepDir(drive) => drive.begin(axes),
            Wired::Coils(drive) => drive.begin(axes),
        }
    }

    fn end(&mut self, axes: Axes) {
        match self {
            Wired::StepDir(drive) => drive.end(axes),
            Wired::Coils(drive) => drive.end(axes),
        }
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        match self {
            Wired::StepDir(drive) => drive.direction(axis, forward),
            Wired::Coils(drive) => drive.direction(axis, forward),
        }
    }
}

impl Output for Wired {
    fn on(&mut self) {
        if let Wired::Coils(drive) = self {
            drive.on();
        }
    }

    fn off(&mut self) {
        if let Wired::Coils(drive) = self {
            drive.off();
        }
    }
}

/// Pins of a port as outputs.
fn port(letter: u8, mask: u8) -> Option<AnyPort> {
    let mut port = AnyPort::of(letter, mask)?;
    port.drive(mask);
    Some(port)
}

fn step_dir() -> Option<Wired> {
    let (letter, step, direction) = STEP_DIR;
    let port = port(letter, 1 << step | 1 << direction)?;
    Some(Wired::StepDir(PortDrive::new(port, step, direction, 0)))
}

fn windings((sequence, mask): (Sequence, u8)) -> Option<Wired> {
    Some(Wired::Coils(Coils::new(port(WINDINGS, mask)?, sequence, mask)))
}

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once, with interrupts off.
    let mut motor = unsafe { motor::take() };
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };
    let drives = [step_dir()].into_iter().chain(TABLES.into_iter().map(windings));
    for drive in drives.flatten() {
        motor.wire(drive);
        for forward in [true, false] {
            let (steps, first, shortest) = DEMO;
            motor.play(Fixed::new(steps, first, shortest), forward);
            while motor.is_moving() {}
        }
    }
    loop {}
}
