#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::{Accel, Axis, AxisLimits, MoveError, Speed};
use stepwright_avr::{lamp, steppers::Steppers};

stepwright_avr::steppers!(main);

fn main(motors: &mut Steppers) -> Result<(), MoveError> {
    let limits = AxisLimits::new(Speed::of::<4_000>(), Accel::of::<10_000>());
    motors.set_limits(Axis::X, limits);
    motors.move_to(Axis::X, 8_000)?; // returns at once: the interrupts make the steps
    while motors.is_moving(Axis::X) {
        motors.poll(); // plans ahead
        lamp::toggle(); // your own work
    }
    Ok(())
}
