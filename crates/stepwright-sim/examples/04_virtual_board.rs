//! A motor that moves in the background: the README's first example on simulated pins.
//!
//! `cargo run -p stepwright-sim --example 04_virtual_board`

use stepwright::{Accel, Axis, AxisLimits, MoveError, Speed};
use stepwright_sim::{Description, Edge, Queues, virtual_steppers};

fn main() -> Result<(), MoveError> {
    let mut queues = Queues::default();
    let mut motors = virtual_steppers(&mut queues, Description::uno(), Vec::<Edge>::new());
    let limits = AxisLimits::new(Speed::of::<4_000>(), Accel::of::<10_000>());
    motors.set_limits(Axis::X, limits);
    motors.move_to(Axis::X, 8_000)?; // returns at once: the engine makes the steps
    while motors.is_moving(Axis::X) {
        motors.poll(); // plans ahead
        motors.engine().pass(16_000); // your own work: a millisecond passes
    }

    let steps = motors.engine().recorder().iter().filter(|edge| edge.is_step()).count();
    let (position, late) = (motors.position(Axis::X), motors.late());
    println!(
        "{steps} steps to {position:?}, {late} late, in {} ms",
        motors.engine().now() / 16_000
    );
    assert_eq!((position, steps, late), (Some(8_000), 8_000, 0));

    // Faster than the board can step is refused before anything moves.
    let fast = AxisLimits::new(Speed::of::<200_000>(), Accel::of::<1_000_000>());
    motors.set_limits(Axis::X, fast);
    println!("{}", motors.run(Axis::X, 200_000).unwrap_err());
    Ok(())
}
