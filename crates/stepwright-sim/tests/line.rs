//! The statements of the documentation of `move_line_to` about an axis with few steps.

use stepwright::profile::Unfit;
use stepwright::{Accel, Axis, AxisLimits, MoveError, Refusal, Speed};
use stepwright_sim::{Description, Edge, Queues, VirtualSteppers, virtual_steppers};

const HZ: f64 = 16e6;
const MILLI: u32 = 16_000;

fn with_motors(test: impl FnOnce(&mut VirtualSteppers<'_, Vec<Edge>>)) {
    let mut queues = Queues::default();
    let mut motors = virtual_steppers(&mut queues, Description::uno(), Vec::new());
    for axis in [Axis::X, Axis::Y] {
        motors.set_limits(axis, AxisLimits::new(Speed::of::<600>(), Accel::of::<1_000>()));
    }
    test(&mut motors);
}

#[test]
fn it_ends_a_little_apart_from_the_others() {
    for (few, end) in [(2, 143.5), (60, 150.7), (1_000, 150.6)] {
        with_motors(|motors| {
            motors.move_line_to([(Axis::X, 90_000), (Axis::Y, few)]).unwrap();
            while motors.any_moving() {
                let wait = motors.poll().unwrap_or(MILLI);
                motors.engine().pass(wait);
            }
            let edges = motors.engine().recorder();
            let last = |axis| edges.iter().rfind(|edge| edge.is_step() && edge.axis == axis);
            let ends = [0, 1].map(|axis| last(axis).unwrap().time as f64 / HZ);
            assert!((ends[0] - 150.6).abs() < 0.05 && (ends[1] - end).abs() < 0.05, "{ends:?}");
            let share = 600.0 * (few - 1) as f64 / 89_999.0;
            let apart = (ends[0] - ends[1]).abs() / ends[0];
            assert!(apart <= 0.000_5 / share, "{apart} of the time at {share} steps/s");
        });
    }
}

#[test]
fn two_steps_too_far_apart_are_refused_and_single_ones_are_not() {
    with_motors(|motors| {
        let slow = MoveError::Refused(Refusal::Unfit(Unfit::TooSlow));
        assert_eq!(motors.move_line_to([(Axis::X, 140_000), (Axis::Y, 2)]), Err(slow));
        assert!(!motors.any_moving());
        assert_eq!(motors.move_line_to([(Axis::X, 70_000), (Axis::Y, 1)]), Ok(()));
    });
}
