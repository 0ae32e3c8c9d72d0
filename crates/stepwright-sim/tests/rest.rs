//! Travels of a motor are at least a start interval apart, whatever is between them: another order, a turn, a
//! new target at the end, a soft stop.

use crate::edges;
use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

type Board<'q> = VirtualBoard<'q, u16, Vec<Edge>>;

const MS: u64 = 16_000;

fn say(board: &mut Board, lines: &str) {
    for line in lines.split_whitespace() {
        line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
        assert_eq!(board.take_answers(), b"Y\r", "{line}");
    }
}

/// The intervals between the pulses of an axis, in ticks, after `tell` has given the board its lines.
fn intervals(axis: u8, tell: impl FnOnce(&mut Board)) -> Vec<u64> {
    let mut queues = Queues::default();
    let mut board = Board::new(&mut queues, Description::uno(), Vec::new());
    tell(&mut board);
    board.run_to_rest();
    assert_eq!(board.late(), 0);
    let steps = edges::steps_of(board.recorder(), axis);
    steps.windows(2).map(|pair| pair[1].0 - pair[0].0).collect()
}

/// Single steps at 20 steps/s, each ordered as soon as the axis is ready.
#[test]
fn orders_of_a_step_keep_the_start_interval() {
    let between = intervals(0, |board| {
        for order in ["PO S2 T2 G+1 E", "PO G+1 E", "PO G-1 E", "PO G-1 E", "PO G+1 E"] {
            board.run_to_rest();
            say(board, order);
        }
    });
    assert_eq!(between.len(), 4);
    assert!(between.iter().all(|t| (50 * MS..54 * MS).contains(t)), "{between:?}");
}

/// From rest the interval is the first one of a ramp: √(2/10,000) s, 14.1 ms.
#[test]
fn from_rest_it_is_the_first_interval_of_a_ramp() {
    let between = intervals(0, |board| {
        for order in ["PO s0 t1000 a10000 d10000 G+1 E", "PO G+1 E", "PO G-1 E"] {
            board.run_to_rest();
            say(board, order);
        }
    });
    let first = 226_274; // 16 MHz · √(2/10,000)
    assert_eq!(between.len(), 2);
    assert!(between.iter().all(|&t| t >= first && t < first + 4 * MS), "{between:?}");
}

/// If the ramp is over within the first step, the interval is one of the top speed.
#[test]
fn from_rest_it_is_no_shorter_than_at_the_top_speed() {
    let between = intervals(0, |board| {
        for order in ["PO s0 t500 a3000000 d3000000 G+1 E", "PO G+1 E", "PO G-1 E"] {
            board.run_to_rest();
            say(board, order);
        }
    });
    assert_eq!(between.len(), 2);
    assert!(between.iter().all(|t| (2 * MS..6 * MS).contains(t)), "{between:?}");
}

/// The time since the last step counts: a late order begins at once.
#[test]
fn an_order_long_after_does_not_wait() {
    let mut queues = Queues::default();
    let mut board = Board::new(&mut queues, Description::uno(), Vec::new());
    say(&mut board, "PO S2 T2 G+1 E");
    board.run_until(200 * MS);
    let told = board.now();
    say(&mut board, "PO G+1 E");
    board.run_to_rest();
    let last = edges::steps_of(board.recorder(), 0)[1].0;
    assert!(last - told < MS, "{} ticks", last - told);
}

/// A target behind the axis: through rest, and back.
#[test]
fn a_reversal_keeps_it_too() {
    let between = intervals(0, |board| {
        say(board, "PO s40 t400 a4000 d4000 G+400 E");
        board.run_until(300 * MS);
        say(board, "@-100");
    });
    let longest = between.iter().max().unwrap();
    assert!((25 * MS..29 * MS).contains(longest), "{longest}");
}

/// A new target after the last step was planned and before it is made.
#[test]
fn a_target_at_the_end_keeps_it_too() {
    let between = intervals(0, |board| {
        say(board, "PO S2 T2 G+3 E");
        // Steps at 0, 50 and 100 ms.
        board.run_until(90 * MS);
        say(board, "@+5");
    });
    assert_eq!(between.len(), 4);
    assert!(between.iter().all(|&t| t + 1 >= 50 * MS && t < 54 * MS), "{between:?}");
}

/// After a soft stop. Axes that are ordered together wait for the axis that has to wait.
#[test]
fn a_stop_and_a_group_keep_it_too() {
    let mut queues = Queues::default();
    let mut board = Board::new(&mut queues, Description::uno(), Vec::new());
    say(&mut board, "PO s40 t400 a4000 d4000 g+ E");
    board.run_until(400 * MS);
    say(&mut board, "Z");
    board.run_to_rest();
    let stopped = board.now();
    say(&mut board, "PO G+1 A2 G+1 E");
    board.run_to_rest();
    let last = |board: &mut Board, axis| edges::steps_of(board.recorder(), axis).last().unwrap().0;
    let (x, y) = (last(&mut board, 0), last(&mut board, 1));
    assert!(x - stopped >= 25 * MS - 100 && x.abs_diff(y) < 1_000, "{stopped} {x} {y}");
}

/// A kill at rest does not shorten the rest of the last travel, even after a refused order.
#[test]
fn a_refused_order_and_a_kill_leave_the_rest_as_it_is() {
    let between = intervals(0, |board| {
        say(board, "PO S2 T2 G+1 E");
        board.run_to_rest();
        b"PO\rs5000\rt500000\rg+\rE\r".iter().for_each(|&byte| board.receive(byte));
        assert_eq!(board.take_answers(), b"Y\rY\rY\rY\rE\r");
        say(board, "K PO S2 T2 G+1 E");
    });
    assert_eq!(between.len(), 1);
    assert!((50 * MS..54 * MS).contains(&between[0]), "{between:?}");
}
