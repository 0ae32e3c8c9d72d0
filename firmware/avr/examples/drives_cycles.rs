//! Motor cycles on several drives in turn: one motor on step and direction, and a second one on
//! bridges, on unipolar windings and on an L6219, there and back.
//!
//! | | STEP, DIR | windings |
//! | --- | --- | --- |
//! | Uno | D2, D5 | D8 to D13 (port B) |
//! | Mega | D36, D35 (port C) | D22 to D27 (port A) |
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

#[path = "drives/table.rs"]
mod table;

use stepwright_avr::cycle_drives::CycleMotors;
use stepwright_avr::drives::AnyDrive;
use stepwright_avr::lamp;
use stepwright_cycle::{Calibration, Motor, Program, Refusal};

stepwright_avr::cycle_motors!(
    /// Two motors on timer 1.
    mod motors, 2, AnyDrive
);

/// 150 steps of the first motor and 100 of the second, at the same time.
fn play(motors: &mut CycleMotors<AnyDrive, 2>, forward: bool) -> Result<(), Refusal> {
    let sign = if forward { 1 } else { -1 };
    motors.with(|cycle| {
        let first = Program::Steps { count: 150 * sign, delay: 1_500 };
        let second = Program::Steps { count: 100 * sign, delay: 2_100 };
        cycle.prepare(0, first, Calibration::None)?;
        cycle.prepare(1, second, Calibration::None)?;
        cycle.start()
    })?;
    while motors.with(|cycle| cycle.is_running()) {}
    Ok(())
}

fn run(motors: &mut CycleMotors<AnyDrive, 2>) -> Result<(), Refusal> {
    for windings in table::WINDINGS {
        if let Some(drive) = table::windings(windings) {
            motors.with(|cycle| cycle.drive().wire(1, drive));
        }
        play(motors, true)?;
        play(motors, false)?;
    }
    Ok(())
}

#[avr_device::entry]
fn main() -> ! {
    if let (Some(first), Some(second)) = (table::step_dir(), table::windings(table::WINDINGS[0])) {
        let motor = Motor::new(1, 1_000);
        // SAFETY: called once, with interrupts off.
        let mut motors = unsafe { motors::take([motor, motor], [first, second]) };
        // SAFETY: everything that an interrupt uses is set up.
        unsafe { avr_device::interrupt::enable() };
        if run(&mut motors).is_err() {
            lamp::set(true);
        }
    }
    loop {}
}
