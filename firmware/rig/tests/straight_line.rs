//! A straight line of a program's own: on a Mega its functions took arguments on the stack, which
//! the compiler reads a byte too low, and X moved 60 times too slowly.

use stepwright::{Accel, Axis, AxisLimits, Speed};
use stepwright_rig::board::HZ;
use stepwright_rig::edges::{Needs, check, steps_of};
use stepwright_rig::{Chip, firmware};
use stepwright_sim::{Description, Edge, Queues, virtual_steppers};

use crate::common::board;

/// The edges of the same calls on the virtual board.
fn ideal() -> Vec<Edge> {
    let mut queues = Queues::default();
    let mut motors = virtual_steppers(&mut queues, Description::uno(), Vec::new());
    for axis in [Axis::X, Axis::Y] {
        motors.set_limits(axis, AxisLimits::new(Speed::of::<4_000>(), Accel::of::<10_000>()));
    }
    motors.move_line_to([(Axis::X, 2_000), (Axis::Y, 300)]).unwrap();
    while motors.any_moving() {
        motors.poll();
        motors.engine().pass(1_000);
    }
    std::mem::take(motors.engine().recorder())
}

#[test]
fn two_axes_keep_to_a_line_and_end_together() {
    let image = firmware::load(&format!("{}-straight-line", board().name()))
        .unwrap_or_else(|error| panic!("{error:#}"));
    let mut chip = Chip::new(board(), &image);
    assert!(chip.run_to_silence(HZ / 2, 4 * HZ), "it does not come to rest");

    assert_eq!(check(chip.edges(), Needs::DEFAULT), Ok(()));
    let ideal = ideal();
    let begin = steps_of(chip.edges(), 0)[0].time;
    let ideal_begin = steps_of(&ideal, 0)[0].time;
    for (axis, end) in [(0, 2_000), (1, 300)] {
        let (real, ideal) = (steps_of(chip.edges(), axis), steps_of(&ideal, axis));
        assert_eq!(real.last().map(|step| step.position), Some(end));
        assert_eq!(real.len(), ideal.len());
        let off = real
            .iter()
            .zip(&ideal)
            .map(|(real, ideal)| (real.time - begin).abs_diff(ideal.time - ideal_begin));
        let worst = off.max().unwrap_or(0);
        assert!(worst <= 200, "axis {axis}: {worst} cycles off the virtual board");
    }
    assert!(steps_of(chip.edges(), 2).is_empty());
}
