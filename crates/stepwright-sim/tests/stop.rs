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

/// Other limits after Z: it stops along them, and neither comes back to where it would have
/// stopped nor speeds up to get there.
#[test]
fn other_limits_change_the_stop_and_not_its_end() {
    // From 45,000 to 50,000 steps/s: the fall has begun, and what is planned of it is made.
    let way = |d: i64| 45_000 * 45_000 / 2 / d..50_000 * 50_000 / 2 / d + 24 * 50;
    for (limits, way) in [("d20000", way(20_000)), ("d400000 a1000000 t60000", way(400_000))] {
        told("a200000 d100000 t50000", "Y Y Y", |board| {
            board.run_until(2_000 * MS);
            assert_eq!(say(board, "Z"), "Y");
            board.run_until(board.now() + 30 * MS);
            assert_eq!(say(board, limits).replace("Y", "").trim(), "");
            let before = board.position(0).unwrap();
            board.run_to_rest();
            let steps = edges::steps_of(board.recorder(), 0);
            let last: Vec<_> = steps.iter().filter(|step| step.1 >= before).collect();
            assert!(last.windows(2).all(|pair| pair[1].1 == pair[0].1 + 1), "{limits}: it turns");
            let interval = |pair: &[&(u64, i64)]| pair[1].0 - pair[0].0;
            let falls = last.windows(3).all(|w| interval(&w[1..]) + 1 >= interval(&w[..2]));
            assert!(falls, "{limits}: it speeds up");
            let made = board.position(0).unwrap() - before;
            assert!(way.contains(&made), "{limits}: {made} steps");
        });
    }
}

/// Where a corner was played as a level step a fall is no faster than its own steps take, so
/// that no change finds it too fast for its end.
#[test]
fn a_change_where_the_fall_begins_goes_not_beyond_the_end() {
    let rate = stepwright::Rate::from_hz(1_787_804).unwrap();
    for change in ["Z", "a9000000", "t70000", "@-1635", "d160039"] {
        for steps in 1600..1670 {
            let mut queues = Queues::default();
            let quick = Description::quick(rate, [18, 29, 33]);
            let mut board = Board::new(&mut queues, quick, Vec::new());
            say(&mut board, &format!("d160038 PO t76484 s27516 G-{steps} E"));
            say(&mut board, change.replace("1635", &steps.to_string()).as_str());
            board.run_to_rest();
            let steps_made = edges::steps_of(board.recorder(), 0);
            assert!(steps_made.iter().all(|step| step.1 >= -steps), "{change}, {steps} steps");
        }
    }
}

/// Nothing is planned beyond the first step while an axis waits for it: a stop then is obeyed
/// there.
/// The next step is queued while the present one is waited for: nobody but the interrupt
/// knows how much is left of it.
#[test]
fn at_slow_speeds_a_stop_leaves_the_present_step_and_the_next() {
    let mut queues = Queues::default();
    let mut board = Board::new(&mut queues, Description::uno(), Vec::new());
    assert_eq!(say(&mut board, "PO s2 t2 G+20 E"), "Y Y Y Y Y");
    for (at, stop, end) in [(1_250, "", 3), (1_251, "Z", 3), (2_100, "", 5), (9_000, "", 5)] {
        board.run_until(at * MS);
        assert_eq!(say(&mut board, stop), if stop.is_empty() { "" } else { "Y" });
        assert_eq!(board.position(0), Some(end), "{at} ms");
    }
}

#[test]
fn a_stop_in_the_wait_before_a_travel_leaves_one_step() {
    for (settings, first) in [("$enable-ms=100", ""), ("$enable-ms=1", "PO S2 T2 G+1 E")] {
        let mut queues = Queues::default();
        let mut board = Board::new(&mut queues, Description::uno(), Vec::new());
        say(&mut board, settings);
        say(&mut board, first);
        board.run_to_rest();
        let before = board.position(0).unwrap();
        assert_eq!(say(&mut board, "PO s2000 t20000 a400000 d400000 g+ E"), "Y Y Y Y Y Y Y");
        board.run_until(board.now() + 20 * MS);
        assert_eq!(say(&mut board, "Z"), "Y");
        board.run_to_rest();
        assert_eq!(board.position(0).unwrap() - before, 1, "{settings} {first}");
        assert_eq!(board.late(), 0);
    }
}
