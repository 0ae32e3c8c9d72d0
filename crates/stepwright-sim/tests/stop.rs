//! Soft stops on the line: a travel that was ordered at its start speed has no ramps, so it
//! gets another top speed only once it has them, and stops along them.

#[path = "common/edges.rs"]
mod edges;

use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

type Board<'q> = VirtualBoard<'q, u16, Vec<Edge>>;

/// Says these lines, and returns what was answered, a blank between.
fn say(board: &mut Board, lines: &str) -> String {
    for line in lines.split_whitespace() {
        line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
    }
    let answers = String::from_utf8(board.take_answers()).unwrap();
    answers.trim_end().replace('\r', " ")
}

const MS: u64 = 16_000;

/// An endless travel at 1,000 steps/s, to which a second later something is said.
fn told(change: &str, answers: &str, then: impl FnOnce(&mut Board)) {
    let mut queues = Queues::default();
    let mut board = Board::new(&mut queues, Description::uno(), Vec::new());
    assert_eq!(say(&mut board, "PO S100 T100 g+ E"), "Y Y Y Y Y");
    board.run_until(1_000 * MS);
    assert_eq!(say(&mut board, change), answers);
    then(&mut board);
}

#[test]
fn a_travel_without_ramps_gets_no_other_speed() {
    told("t50000", "E", |board| {
        assert!(say(board, "?").contains("last=too-gentle"));
        board.run_until(2_000 * MS);
        let before = board.position(0).unwrap();
        assert_eq!(say(board, "Z"), "Y");
        board.run_to_rest();
        // It goes on at its start speed, and stops from it.
        let steps = edges::steps_of(board.recorder(), 0);
        let slow = |pair: &[(u64, i64)]| (15_990..16_010).contains(&(pair[1].0 - pair[0].0));
        assert!(steps.windows(2).all(slow));
        assert!(board.position(0).unwrap() - before <= 26);
    });
    // One ramp is not enough.
    told("a200000 t50000", "Y E", |_| {});
    told("d200000 t50000", "Y E", |_| {});
}

/// What stops an endless travel at 50,000 steps/s, and the steps that it still made.
fn stopped(stop: impl FnOnce(&mut Board)) -> i64 {
    let mut made = 0;
    told("a200000 d100000 t50000", "Y Y Y", |board| {
        board.run_until(2_000 * MS);
        stop(board);
        let before = board.position(0).unwrap();
        board.run_to_rest();
        made = board.position(0).unwrap() - before;
        assert_eq!(board.late(), 0);
    });
    made
}

#[test]
fn a_stop_ends_within_the_braking_distance() {
    // 24 ms at 50,000 steps/s are planned ahead at most, and then it falls.
    let way = (50_000 * 50_000 - 1_000 * 1_000) / 200_000;
    let most = way + 24 * 50 + 1;
    let made = stopped(|board| assert_eq!(say(board, "Z"), "Y"));
    assert!((way..=most).contains(&made), "{made} steps");
}

#[test]
fn a_silent_host_is_stopped_for_within_the_braking_distance() {
    let mut queues = Queues::default();
    let mut board = Board::new(&mut queues, Description::uno(), Vec::new());
    assert_eq!(say(&mut board, "$timeout-ms=500 PO S100 T100 g+ E"), "Y Y Y Y Y Y");
    board.run_until(400 * MS);
    assert_eq!(say(&mut board, "t50000 a200000 d100000 t50000"), "E Y Y Y");
    board.run_until(899 * MS);
    let before = board.position(0).unwrap();
    board.run_to_rest();
    let way = (50_000 * 50_000 - 1_000 * 1_000) / 200_000;
    let made = board.position(0).unwrap() - before;
    assert!((way..=way + 26 * 50).contains(&made), "{made} steps");
}
