//! X finds its position 0 by a limit switch between D9 and ground.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::{Accel, Axis, AxisLimits, MoveError, Speed};
use stepwright_avr::steppers::{Steppers, is_pressed};

stepwright_avr::steppers!(main);

fn main(motors: &mut Steppers) -> Result<(), MoveError> {
    let limits = AxisLimits::new(Speed::of::<4_000>(), Accel::of::<10_000>());
    motors.set_limits(Axis::X, limits);
    home(motors)?;
    motors.move_to(Axis::X, 500)
}

/// Fast towards the switch, and slowly off it; there 0 is.
fn home(motors: &mut Steppers) -> Result<(), MoveError> {
    for (speed, pressed) in [(-1_000, true), (100, false)] {
        motors.run(Axis::X, speed)?;
        while is_pressed(Axis::X) != pressed {
            motors.poll();
        }
        motors.stop(Axis::X); // brakes: the switch must allow for the way
        while motors.is_moving(Axis::X) {
            motors.poll();
        }
    }
    motors.set_position(Axis::X, 0)
}
