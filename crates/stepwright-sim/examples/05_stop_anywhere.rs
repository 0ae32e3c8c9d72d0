//! Run endlessly, stop from anywhere, and know where you are.
//!
//! `cargo run -p stepwright-sim --example 05_stop_anywhere`

use stepwright::{Accel, Axis, AxisLimits, MoveError, Speed};
use stepwright_sim::{Description, Queues, VirtualSteppers, virtual_steppers};

/// Runs a main loop for this many milliseconds.
fn work(motors: &mut VirtualSteppers<'_, ()>, millis: u32) {
    for _ in 0..millis {
        motors.poll();
        motors.engine().pass(16_000);
    }
}

fn main() -> Result<(), MoveError> {
    let mut queues = Queues::default();
    let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    let limits = AxisLimits::new(Speed::of::<1_000>(), Accel::of::<2_500>());
    motors.set_limits(Axis::Z, limits.start_speed(Speed::of::<50>()));
    motors.run(Axis::Z, 1_000)?;
    work(&mut motors, 700);
    println!("after 700 ms at {:?}", motors.position(Axis::Z));

    // Another top speed on the way, reached with a lower acceleration.
    motors.set_acceleration(Axis::Z, Accel::of::<1_000>())?;
    motors.set_top_speed(Axis::Z, Speed::of::<400>())?;
    work(&mut motors, 700);
    motors.set_top_speed(Axis::Z, Speed::of::<1_000>())?;
    work(&mut motors, 700);
    println!("after three speeds at {:?}", motors.position(Axis::Z));

    // A stop: along the ramp, position kept.
    motors.stop(Axis::Z);
    println!("rests {:?} steps from here", motors.distance_to_go(Axis::Z));
    work(&mut motors, 500);
    println!("at rest at {:?}", motors.position(Axis::Z));
    assert!(!motors.is_moving(Axis::Z) && motors.position(Axis::Z).is_some());

    // A kill: at once, and the position is unknown until it is set.
    motors.run(Axis::Z, 1_000)?;
    work(&mut motors, 700);
    motors.kill(Axis::Z);
    println!("killed: position {:?}", motors.position(Axis::Z));
    println!("{}", motors.move_to(Axis::Z, 0).unwrap_err());
    motors.set_position(Axis::Z, 0)?;
    assert_eq!(motors.position(Axis::Z), Some(0));
    Ok(())
}
