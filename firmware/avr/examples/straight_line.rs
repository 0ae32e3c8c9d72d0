//! X and Y move along a straight line, and end together.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::{Accel, Axis, AxisLimits, MoveError, Speed};
use stepwright_avr::{lamp, steppers::Steppers};

stepwright_avr::steppers!(main);

fn main(motors: &mut Steppers) -> Result<(), MoveError> {
    let limits = AxisLimits::new(Speed::of::<4_000>(), Accel::of::<10_000>());
    for axis in [Axis::X, Axis::Y] {
        motors.set_limits(axis, limits);
    }
    motors.move_line_to([(Axis::X, 2_000), (Axis::Y, 300)])?;
    while motors.any_moving() {
        motors.poll();
        lamp::toggle();
    }
    Ok(())
}
