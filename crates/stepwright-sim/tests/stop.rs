//! Soft stops on the serial line. A travel that was ordered at its start speed has no ramps: its top speed can
//! change only once it has ramps, and it stops along them.

use crate::edges;
use stepwright::Rate;
use stepwright::timer::Count;
use stepwright_sim::{Description, Edge, Queues, VirtualBoard};

type Board<'q> = VirtualBoard<'q, u16, Vec<Edge>>;

/// Says these lines, and returns the answers, separated by blanks.
fn say(board: &mut Board, lines: &str) -> String {
    for line in lines.split_whitespace() {
        line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
    }
    let answers = String::from_utf8(board.take_answers()).unwrap();
    answers.trim_end().replace('\r', " ")
}

const MS: u64 = 16_000;

/// An endless travel at 1,000 steps/s, to which `change` is said after a second.
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

/// Stops an endless travel at 50,000 steps/s, and returns the steps that it still made.
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
    // At most 24 ms at 50,000 steps/s are planned ahead, then it falls.
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

/// Other limits after Z: the axis stops along them. It neither comes back to where it would have stopped, nor
/// speeds up to get there.
#[test]
fn other_limits_change_the_stop_and_not_its_end() {
    // From 45,000 to 50,000 steps/s: the fall has begun, and its planned part is made.
    let way = |d: i64| 45_000 * 45_000 / 2 / d..50_000 * 50_000 / 2 / d + 24 * 50;
    for (limits, way) in [("d20000", way(20_000)), ("d400000 a500000 t60000", way(400_000))] {
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

/// If a corner was played as a step at constant speed, a fall is no faster than its own steps allow, so no
/// change finds it too fast for its end.
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

/// Nothing is planned beyond the first step while an axis waits for it: a stop then takes effect at that step.
#[test]
fn at_slow_speeds_a_stop_leaves_the_present_step() {
    let mut queues = Queues::default();
    let mut board = Board::new(&mut queues, Description::uno(), Vec::new());
    assert_eq!(say(&mut board, "PO s2 t2 G+20 E"), "Y Y Y Y Y");
    for (at, stop, end) in [(1_250, "", 3), (1_251, "Z", 3), (1_600, "", 4), (9_000, "", 4)] {
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

/// The times of axis 1's steps.
fn steps_of_axis(edges: &[Edge]) -> Vec<u64> {
    edges::steps_of(edges, 0).into_iter().map(|step| step.0).collect()
}

/// During a step of a slow travel the speed is raised to 100 times, and some time later the travel is stopped:
/// the planned part of the rise lasts at most 24 ms, whenever the stop comes.
#[test]
fn a_stop_in_a_slow_step_ends_the_rise() {
    for (order, change) in [
        ("PO s3 m199073 R185 g+ E", "t20293 a2869015"),
        ("PO s1 t19 R900 G+100000 E", "t20000 a2000000 d2000000"),
    ] {
        for stop in (52..1_200).step_by(7) {
            let mut queues = Queues::default();
            let mut uno = Description::uno();
            // Otherwise the board would refuse such a ramp.
            uno.board.runs = u16::MAX;
            let mut board = Board::new(&mut queues, uno, Vec::new());
            assert!(!say(&mut board, order).contains('E'));
            board.run_until(50 * MS);
            assert!(!say(&mut board, change).contains('E'));
            board.run_until(stop * MS);
            assert_eq!(say(&mut board, "Z"), "Y");
            board.run_until((stop + 24) * MS);
            let before = steps_of_axis(board.recorder()).len();
            board.run_until((stop + 400) * MS);
            let steps = steps_of_axis(board.recorder());
            let from = before.saturating_sub(2);
            let intervals: Vec<u64> =
                steps[from..].windows(2).map(|pair| pair[1] - pair[0]).collect();
            let rise = intervals.windows(2).find(|pair| pair[1] + 2 < pair[0]);
            assert_eq!(rise, None, "{order}, stopped at {stop} ms");
        }
    }
}

/// The same for every width and rate of the timer's counter.
#[test]
fn a_stop_and_a_change_hold_for_all_of_a_wait() {
    fn stopped<C: Count>(hz: u32, said: &str, to: Option<i64>) {
        let rate = Rate::from_hz(hz).unwrap();
        let description = Description::quick(rate, [hz / 100_000 + 2; 3]);
        let mut queues = Queues::default();
        let mut board = VirtualBoard::<C, Vec<Edge>>::new(&mut queues, description, Vec::new());
        let say = |board: &mut VirtualBoard<C, Vec<Edge>>, lines: &str| {
            for line in lines.split_whitespace() {
                line.bytes().chain([b'\r']).for_each(|byte| board.receive(byte));
            }
            let answers = String::from_utf8(board.take_answers()).unwrap();
            assert!(!answers.contains('E'), "{hz}: {lines}: {answers}");
        };
        let ms = u64::from(hz / 1_000);
        say(&mut board, "$enable-ms=1000");
        say(&mut board, "PO s20 t2000 a100000 d100000 G+10000 E");
        board.run_until(board.now() + 100 * ms);
        say(&mut board, said);
        board.run_to_rest();
        let steps = steps_of_axis(board.recorder());
        match to {
            Some(to) => {
                assert_eq!(steps.len(), 10_000, "{hz}: {said}");
                // With the new limits from the first step on: v² ≤ 20² + 2·163·n.
                for (n, pair) in (1u32..).zip(steps.windows(2)).take(50) {
                    let v = f64::from(hz) / (pair[1] - pair[0]) as f64;
                    assert!(v * v < 1.01 * (400.0 + 326.0 * f64::from(n)), "{hz}: step {n}: {v}");
                }
                assert_eq!(board.position(0), Some(to));
            }
            None => assert_eq!(steps.len(), 1, "{hz}: {said}"),
        }
        assert_eq!(board.late(), 0);
    }
    for said in ["Z", "a163 d68"] {
        let to = (said != "Z").then_some(10_000);
        for hz in [1_000_000, 16_000_000, 84_000_000] {
            stopped::<u32>(hz, said, to);
        }
        for hz in [500_000, 1_000_000, 16_000_000] {
            stopped::<u16>(hz, said, to);
        }
    }
}

/// The planned steps are known however often the queue was filled, also in the fall to a slow speed: nothing is
/// planned ahead of slow steps.
#[test]
fn a_stop_after_slowing_down_leaves_the_step_in_progress() {
    let mut most = 0;
    for (slow, ramp) in
        [(1, 100), (1, 1_000), (1, 20_000), (1, 200_000), (15, 20_000), (15, 200_000)]
    {
        for wait in (1_010..4_000).step_by(37) {
            let mut queues = Queues::default();
            let mut board = Board::new(&mut queues, Description::uno(), Vec::new());
            let order = format!("PO s1 t1600 a20000 d{ramp} g+ E");
            assert!(!say(&mut board, &order).contains('E'));
            board.run_until(1_000 * MS);
            assert!(!say(&mut board, &format!("t{slow}")).contains('E'));
            board.run_until(wait * MS + 16_000 * MS * u64::from(ramp == 100));
            let told = board.now();
            assert_eq!(say(&mut board, "Z"), "Y");
            board.run_until(told + 24 * MS);
            let before = steps_of_axis(board.recorder()).len();
            board.run_to_rest();
            let steps = steps_of_axis(board.recorder());
            // After 24 ms, or at slow speeds after the step in progress: the remaining part of a step, and the
            // fall from the speed at that time.
            let ahead = &steps[before.saturating_sub(2)..];
            let v = 16e6 / (ahead[1] - ahead[0]) as f64;
            let way = v * v / 2.0 / f64::from(ramp) + 2.01;
            let made = steps.len() - before;
            assert!(made as f64 <= way, "{slow}, {ramp}, {wait} ms: {made} steps, not {way}");
            most = most.max(made);
        }
    }
    assert!(most > 1);
}
