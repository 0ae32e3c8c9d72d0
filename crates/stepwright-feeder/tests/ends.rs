//! How runs end that do not come to their end: stopped again and again, before they start, behind their last
//! step, in a dwell, by a board that says nothing any more.

use stepwright_feeder::{FeedState, FeedTerms, StreamFeeder};
use stepwright_sim::{Edge, Queues, StreamBoard};

use crate::common::{HZ, Job, MILLIS, Step, board, s_curve, steps_of, terms};

/// Steps at one speed, in steps/s, from a time on.
fn steady(from: f64, steps: usize, speed: f64) -> Vec<Step> {
    (0..steps).map(|n| (from + n as f64 / speed, true)).collect()
}

/// A run on a board by a line without delay. `befalls` is told the board, the feeder and the ms since the
/// beginning; false ends the host's life in this ms.
fn host(
    board: &mut StreamBoard<'_, Vec<Edge>>,
    mut job: Job,
    terms: FeedTerms,
    mut befalls: impl FnMut(&mut StreamBoard<'_, Vec<Edge>>, &mut StreamFeeder, u64) -> bool,
) -> (FeedState, u64) {
    let axes = (0..3).filter(|axis| !job.axes[*axis].is_empty()).map(|axis| 1 << axis).sum();
    let mut feeder = StreamFeeder::new(FeedTerms { axes, ..terms }, 0);
    for millis in 1..20_000 {
        board.run_until(millis * MILLIS);
        if !befalls(board, &mut feeder, millis) {
            continue;
        }
        let said = board.take_answers();
        feeder.hear(&said, millis * 1_000);
        job.feed(&mut feeder);
        let bytes = feeder.bytes(millis * 1_000);
        board.receive(&bytes);
        if feeder.state().is_end() {
            return (feeder.state(), millis);
        }
    }
    (feeder.state(), 20_000)
}

#[test]
fn a_second_stop_does_not_speed_up() {
    let counts = |stops: &[u64]| {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        let job = Job::new([s_curve(60_000, 30_000.0, 40_000.0, 400_000.0), vec![], vec![]]);
        let state = host(&mut board, job, terms([40_000.0, 1.0e3, 1.0e3]), |_, feeder, millis| {
            if stops.contains(&millis) {
                feeder.say("Z");
            }
            true
        });
        assert_eq!(state.0, FeedState::Off);
        board.run_until(4_000 * MILLIS);
        let mut counts = vec![0i32; 80];
        for (time, _) in steps_of(board.recorder(), 0) {
            counts[(time / (50 * MILLIS)) as usize] += 1;
        }
        assert!(!board.is_busy());
        counts
    };
    let once = counts(&[800]);
    // The host hears of it and says no more: the others come from a second terminal.
    assert!(once[17..].windows(2).all(|pair| pair[1] <= pair[0]), "{once:?}");
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    let job = Job::new([s_curve(60_000, 30_000.0, 40_000.0, 400_000.0), vec![], vec![]]);
    host(&mut board, job, terms([40_000.0, 1.0e3, 1.0e3]), |_, feeder, millis| {
        if millis == 800 {
            feeder.say("Z");
        }
        true
    });
    for millis in (1_000..2_000).step_by(100) {
        board.run_until(millis * MILLIS);
        board.receive(b"Z\r");
    }
    board.run_until(4_000 * MILLIS);
    let mut often = vec![0i32; 80];
    for (time, _) in steps_of(board.recorder(), 0) {
        often[(time / (50 * MILLIS)) as usize] += 1;
    }
    assert_eq!(once, often);
}

#[test]
fn a_stop_before_the_start_ends_the_run() {
    for millis in [2, 5, 20, 40] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        let job = Job::new([steady(0.1, 8_000, 4_000.0), vec![], vec![]]);
        let ended = host(&mut board, job, terms([4_000.0; 3]), |_, feeder, now| {
            if now == millis {
                feeder.say("Z");
            }
            true
        });
        assert!(ended.0 == FeedState::Off && ended.1 < millis + 1_000, "{millis}: {ended:?}");
    }
}

/// A board that falls silent: in the middle, while it plays the last that it has, and before it was met.
#[test]
fn a_board_that_says_nothing_any_more_is_lost() {
    for from in [0, 300, 1_900, 2_060] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        let job = Job::new([steady(0.05, 8_000, 4_000.0), vec![], vec![]]);
        let terms = FeedTerms { lease: 0, ..terms([4_000.0; 3]) };
        let ended = host(&mut board, job, terms, |board, _, millis| {
            if millis >= from {
                board.take_answers();
            }
            true
        });
        let lost = ended.0 == FeedState::Lost && ended.1 < from + 3_500;
        assert!(lost, "silent from {from} ms on: {ended:?}");
    }
}

/// A host that was away for longer than that has not lost its board.
#[test]
fn a_computer_that_was_away_has_not_lost_its_board() {
    let mut queues = Queues::default();
    let mut board = board(&mut queues);
    let job = Job::new([steady(0.05, 8_000, 4_000.0), vec![], vec![]]);
    let ended = host(&mut board, job, terms([4_000.0; 3]), |board, feeder, millis| {
        if millis == 6_000 {
            // It writes before it reads what has come meanwhile.
            board.receive(&feeder.bytes(millis * 1_000));
        }
        !(1_000..6_000).contains(&millis)
    });
    assert_eq!(ended.0, FeedState::Off);
}

#[test]
fn a_cut_behind_the_last_step_leaves_an_end() {
    for millis in (1_700..2_080).step_by(7) {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        let path = steady(0.05, 8_000, 4_000.0);
        let end = path.last().unwrap().0;
        let job = Job::new([path, vec![], vec![]]);
        let mut cut = None;
        let ended = host(&mut board, job, terms([4_000.0; 3]), |_, feeder, now| {
            if now >= millis && cut.is_none() {
                cut = feeder.cut(now * 1_000, true);
                if let Some(cut) = cut {
                    feeder.end(end.max(cut.time));
                }
            }
            true
        });
        assert_eq!(ended.0, FeedState::Over, "{millis}: {ended:?}, {cut:?}");
    }
}

/// A host that is away in a dwell, for less than the lease: the axes go on in step, or not at all.
#[test]
fn a_stall_in_a_dwell_leaves_no_axis_behind() {
    let (mut over, mut off) = (0, 0);
    for away in [200, 400, 600, 800, 950] {
        let mut queues = Queues::default();
        let mut board = board(&mut queues);
        let once = |from: f64| steady(from, 1_600, 1_600.0);
        let path: Vec<Step> = [once(0.1), once(3.1)].concat();
        let job = Job::new([path.clone(), path.clone(), vec![]]);
        let ended = host(&mut board, job, terms([100_000.0; 3]), |_, _, millis| {
            !(2_000..2_000 + away).contains(&millis)
        });
        board.run_until(21_000 * MILLIS);
        let [x, y] = [0, 1].map(|axis| steps_of(board.recorder(), axis));
        let apart = x.iter().zip(&y).map(|(x, y)| (x.0 as f64 - y.0 as f64).abs() / HZ);
        let apart = apart.fold(0.0, f64::max);
        match ended.0 {
            FeedState::Over => {
                over += 1;
                assert!(x.len() == path.len() && apart < 50e-6, "{away}: {apart}");
            }
            FeedState::Off => {
                off += 1;
                assert_eq!((x.len(), y.len()), (1_600, 1_600), "{away}");
            }
            state => panic!("{away}: {state:?}"),
        }
        assert!(!board.is_busy());
    }
    assert!(over > 0 && off > 0, "{over} {off}");
}
