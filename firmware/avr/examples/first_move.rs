#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::{Accel, Axis, AxisLimits, MoveError, Speed};
use stepwright_avr::{lamp, steppers::Steppers};

stepwright_avr::steppers!(main);

fn main(motors: &mut Steppers) -> Result<(), MoveError> {
    let (speed, acceleration) = (Speed::from_steps(4_000)?, Accel::from_steps(10_000)?);
    motors.set_limits(Axis::X, AxisLimits::new(speed, acceleration));
    motors.move_to(Axis::X, 8_000)?; // returns at once: the interrupts make the steps
    while motors.is_moving(Axis::X) {
        motors.poll(); // plans ahead
        lamp::toggle(); // your own work
    }
    Ok(())
}
