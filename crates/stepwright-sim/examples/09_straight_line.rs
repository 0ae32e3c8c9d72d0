//! Three axes along a straight line: all begin and end together, and each keeps its limits.
//!
//! `cargo run -p stepwright-sim --example 09_straight_line`

use stepwright::{Accel, Axis, AxisLimits, MoveError, Speed};
use stepwright_sim::{Description, Edge, Pin, Queues, virtual_steppers};

/// The first side of stepper_h's triangle.
const END: [i64; 3] = [20_000, 6_666, 2_666];

fn main() -> Result<(), MoveError> {
    let mut queues = Queues::default();
    let mut motors = virtual_steppers(&mut queues, Description::uno(), Vec::<Edge>::new());
    for axis in Axis::all() {
        let limits = AxisLimits::new(Speed::from_steps(15_000)?, Accel::from_steps(40_000)?);
        motors.set_limits(axis, limits);
    }
    motors.move_line_to(Axis::all().zip(END))?;
    while motors.any_moving() {
        motors.poll();
        motors.engine().pass(1_000);
    }

    for (axis, end) in Axis::all().zip(END) {
        assert_eq!(motors.position(axis), Some(end));
        let steps = motors.engine().recorder().iter();
        let steps = steps.filter(|e| usize::from(e.axis) == axis.index() && e.pin == Pin::Step);
        let times: Vec<u64> = steps.filter(|e| e.level).map(|edge| edge.time).collect();
        let (first, last) = (times[0], times[times.len() - 1]);
        let ms = |ticks: u64| ticks as f64 / 16_000.0;
        println!(
            "axis {}: {:>6} steps, the first at {:.3} ms, the last at {:.3} ms",
            axis.index(),
            times.len(),
            ms(first),
            ms(last)
        );
    }
    Ok(())
}
