//! Whole runs on the virtual board by a serial line, judged by its edges.

use crate::common::*;
use stepwright_feeder::FeedState;
use stepwright_sim::Queues;

/// An edge waits for the pulse of another axis, 2 µs.
const PULSE: f64 = 2.1;

/// The third axis' timer counts every eighth cycle.
const GRID: f64 = 0.5;

fn organic() -> [Vec<Step>; 3] {
    let waves = [(400.0, 1.0), (150.0, 3.1), (30.0, 9.7)];
    [wander(4.0, &waves, 0.0), wander(4.0, &waves, 1.9), wander(4.0, &[(20.0, 0.5)], 0.4)]
}

#[test]
fn three_axes_with_limited_jerk() {
    let axis = |v: f64| s_curve(40_000, v, 40_000.0, 400_000.0);
    let axes = [axis(30_000.0), axis(30_040.0), axis(30_080.0)];
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    let told = run(&mut board, Job::new(axes.clone()), terms([40_000.0; 3]), Line::default());
    assert_eq!((told.state, board.late(), told.again), (FeedState::Over, 0, 0));
    assert_eq!([0, 1, 2].map(|axis| board.position(axis)), [Some(40_000); 3]);
    let (worst, _) = worst(board.recorder(), &axes, 75.0, 0.0);
    assert!(worst < 5.0 + PULSE, "{worst}");
}

#[test]
fn a_motion_that_wanders_with_turns() {
    let axes = organic();
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    let told = run(&mut board, Job::new(axes.clone()), terms([40_000.0; 3]), Line::default());
    assert_eq!((told.state, board.late(), told.again), (FeedState::Over, 0, 0));
    let edges = board.recorder().clone();
    let (worst, _) = worst(&edges, &axes, 75.0, 0.0);
    assert!(worst < 5.0 + PULSE, "{worst}");
    for axis in 0..3u8 {
        assert_eq!(board.position(axis), Some(position_of(&steps_of(&edges, axis))));
    }
}

#[test]
fn spoilt_bytes_lose_no_step() {
    let [x, y, _] = organic();
    let axes = [x, y, vec![]];
    for seed in 1..4 {
        let line = Line { spoils: 100, seed, polls: true, ..Line::default() };
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        let told = run(&mut board, Job::new(axes.clone()), terms([40_000.0; 3]), line);
        assert_eq!((told.state, board.late()), (FeedState::Over, 0), "seed {seed}");
        assert!(told.again > 5 && told.answers > 10, "{} {}", told.again, told.answers);
        // Where little was ahead steps are kept less closely.
        assert!(worst(board.recorder(), &axes, 75.0, 0.0).0 < 25.0 + PULSE);
    }
}

/// One axis after the other, and back, with rests in between: what rests is told to wait, and each step
/// comes on time all the same.
#[test]
fn axes_take_turns() {
    let there: Vec<Step> = s_curve(900, 3_000.0, 30_000.0, 600_000.0);
    let last = there[there.len() - 1].0;
    let mut axes = [vec![], vec![], vec![]];
    for n in 0..6 {
        let from = f64::from(n) * (last + 0.2);
        axes[n as usize % 3].extend(there.iter().map(|step| (from + step.0, n < 3)));
    }
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    let told = run(&mut board, Job::new(axes.clone()), terms([40_000.0; 3]), Line::default());
    assert_eq!((told.state, board.late(), told.again), (FeedState::Over, 0, 0));
    assert_eq!([0, 1, 2].map(|axis| board.position(axis)), [Some(0); 3]);
    let (worst, _) = worst(board.recorder(), &axes, 75.0, 0.0);
    assert!(worst < 5.0 + PULSE + GRID, "{worst}");
}

/// A host that sleeps for 200 ms now and then.
#[test]
fn stalls_are_ridden_through() {
    let axes = organic();
    let sleeps = (0..6).map(|n| (500 * MILLIS + n * 550 * MILLIS, 200 * MILLIS)).collect();
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    let line = Line { sleeps, ..Line::default() };
    let told = run(&mut board, Job::new(axes.clone()), terms([40_000.0; 3]), line);
    assert_eq!((told.state, board.late()), (FeedState::Over, 0));
    assert!(worst(board.recorder(), &axes, 75.0, 0.0).0 < 25.0 + PULSE);
}

/// A run that ends backward, and one after it.
#[test]
fn the_next_run_begins_forward() {
    let there = s_curve(900, 3_000.0, 30_000.0, 600_000.0);
    let end = there[there.len() - 1].0 + 0.1;
    let back = there.iter().map(|step| (end + step.0, false));
    let first = [there.iter().copied().chain(back).collect(), vec![], vec![]];
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    run(&mut board, Job::new(first), terms([40_000.0; 3]), Line::default());
    assert_eq!(board.position(0), Some(0));
    let begun = board.now();
    let mut feeder = stepwright_feeder::StreamFeeder::new(terms([40_000.0; 3]), 0);
    let mut job = Job::new([there, vec![], vec![]]);
    while !feeder.state().is_end() {
        board.run_until(board.now() + MILLIS);
        let now = (board.now() - begun) / 16;
        feeder.hear(&board.take_answers(), now);
        job.feed(&mut feeder);
        let bytes = feeder.bytes(now);
        board.receive(&bytes);
    }
    assert_eq!((feeder.state(), board.position(0)), (FeedState::Over, Some(900)));
}
