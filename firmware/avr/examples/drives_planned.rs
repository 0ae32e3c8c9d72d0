//! Planned moves on several drives in turn: there and back with a trapezoid on step and direction,
//! on bridges, on unipolar windings and on an L6219.
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

use stepwright::{Accel, Axis, AxisLimits, MoveError, Speed};
use stepwright_avr::drives::AnyDrive;
use stepwright_avr::lamp;
use stepwright_avr::planned::Motor as Planned;

stepwright_avr::planned_motor!(
    /// The motor on timer 1.
    mod motor, AnyDrive
);

/// 200 steps there and back on each drive.
fn play(motor: &mut Planned<AnyDrive>) -> Result<(), MoveError> {
    motor.set_limits(Axis::X, AxisLimits::new(Speed::from_steps(800)?, Accel::from_steps(4_000)?));
    // On step and direction first, the motor's initial drive.
    let windings = table::WINDINGS.into_iter().map(Some);
    for drive in core::iter::once(None).chain(windings) {
        if let Some(drive) = drive.and_then(table::windings) {
            motor.engine().rewire(drive);
        }
        for target in [200, 0] {
            motor.move_to(Axis::X, target)?;
            while motor.is_moving(Axis::X) {
                motor.poll();
            }
        }
    }
    Ok(())
}

#[avr_device::entry]
fn main() -> ! {
    if let Some(drive) = table::step_dir() {
        // SAFETY: called once, with interrupts off.
        let mut motor = unsafe { motor::take(drive) };
        // SAFETY: everything that an interrupt uses is set up.
        unsafe { avr_device::interrupt::enable() };
        if play(&mut motor).is_err() {
            lamp::set(true);
        }
    }
    loop {}
}
