//! Homing on the virtual board, with switches at given positions.

use stepwright::Rate;
use stepwright_cycle::{Clock, End, Homing, HomingError, Motor, Refusal};
use stepwright_sim::{CycleBoard, Edge, Pin, Stand};

type Board = CycleBoard<'static, Vec<Edge>, 2>;

fn board(clock: Clock, stand: Stand) -> Board {
    let motors = [Motor::new(10, 200).between(-500, 90_000), Motor::new(1, 200)];
    let rate = Rate::from_hz(16_000_000).unwrap();
    CycleBoard::new(motors, [stand, Stand::default()], clock, rate, Vec::new())
}

fn home(board: &mut Board, mut homing: Homing) -> Result<(), HomingError> {
    while !homing.poll(board.cycle())? {
        board.run_to_rest();
    }
    Ok(())
}

/// The steps of the shaft, by the edges.
fn shaft(board: &mut Board) -> i64 {
    board.with_recorder(|edges| {
        let (mut forward, mut at) = (true, 0);
        for edge in edges.iter().filter(|edge| edge.axis == 0) {
            match edge.pin {
                Pin::Direction => forward = edge.level,
                Pin::Step if edge.level => at += if forward { 1 } else { -1 },
                _ => {}
            }
        }
        at
    })
}

#[test]
fn home_is_where_the_switch_closes() {
    for clock in [Clock::Deadlines, Clock::Tick { period: 50 }] {
        // Before the switch, at it, and one step beside it.
        for min in [-700, -1, 0, 5] {
            let mut board = board(clock, Stand { min: Some(min), max: Some(1_000) });
            let homing = Homing::new(0, End::Min, 5_000, 50).delays(200, 1_000);
            home(&mut board, homing).unwrap();
            assert_eq!(shaft(&mut board), min, "{clock:?}");
            assert_eq!(board.cycle().position(0), Some(-500));
            // And at the other end.
            let homing = Homing::new(0, End::Max, 5_000, 50).delays(200, 1_000);
            home(&mut board, homing).unwrap();
            assert_eq!(shaft(&mut board), 1_000);
            assert_eq!(board.cycle().position(0), Some(90_000));
            assert!(!board.cycle().is_running());
        }
    }
}

#[test]
fn what_keeps_a_motor_from_home_is_said() {
    let home_in = |stand, reach, back_off| {
        let mut board = board(Clock::Deadlines, stand);
        home(&mut board, Homing::new(0, End::Min, reach, back_off))
    };
    let far = Stand { min: Some(-900), max: None };
    assert_eq!(home_in(far, 899, 10), Err(HomingError::NotFound));
    assert_eq!(home_in(far, 900, 10), Ok(()));
    assert_eq!(home_in(Stand::default(), 100, 10), Err(HomingError::NotFound));
    // The motor begins 40 steps beyond the switch.
    let within = Stand { min: Some(40), max: None };
    assert_eq!(home_in(within, 100, 39), Err(HomingError::StillClosed));
    assert_eq!(home_in(within, 100, 41), Ok(()));
    let mut none = board(Clock::Deadlines, Stand::default());
    let refused = home(&mut none, Homing::new(9, End::Min, 1, 1));
    assert_eq!(refused, Err(HomingError::Refused(Refusal::NoMotor)));
}
