//! A board that has not been measured: what it is asked for, and what it refuses.

use stepwright::{Accel, Axis, AxisLimits, Board, MoveError, Rate, Refusal, Speed};
use stepwright_sim::{Description, Queues, VirtualSteppers, virtual_steppers};

/// What becomes of moves at these speeds, ordered one after the other.
fn asked(speeds: &[u32]) -> Result<(), MoveError> {
    let board = Board::unmeasured(Rate::of::<16_000_000>());
    let description = Description { board, ..Description::uno() };
    let mut queues = Queues::default();
    let mut motors: VirtualSteppers<()> = virtual_steppers(&mut queues, description, ());
    for (axis, &speed) in Axis::all().zip(speeds) {
        let top = Speed::from_steps(speed).unwrap();
        motors.set_limits(axis, AxisLimits::new(top, Accel::of::<10_000>()));
        motors.move_by(axis, 20_000)?;
    }
    Ok(())
}

fn at_most(steps: u32) -> Result<(), MoveError> {
    Err(Refusal::TooFast { max: Speed::from_steps(steps).unwrap() }.into())
}

/// 10,000 steps/s in all, and no axis faster than if each other one stepped before each of its steps.
#[test]
fn two_axes_have_5000_steps_a_second_each() {
    for speeds in [&[10_000][..], &[5_000, 5_000], &[4_000, 2_000], &[3_333, 3_333, 3_333]] {
        assert_eq!(asked(speeds), Ok(()), "{speeds:?}");
    }
    assert_eq!(asked(&[10_001]), at_most(10_000));
    assert_eq!(asked(&[4_000, 5_001]), at_most(5_000));
    assert!(matches!(
        asked(&[3_333, 3_333, 3_335]),
        Err(MoveError::Refused(Refusal::TooFast { .. }))
    ));
}

/// The moving axis takes all the time there is.
#[test]
fn an_axis_for_which_no_time_is_left_is_told_so() {
    let refused = asked(&[10_000, 1]).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "too fast for this board: the other moving axes leave no time for this axis; lower their speeds first"
    );
}
