//! The laser of a simulated Mega, by the level of its pin only: D46, in pulses of 7.8 kHz.

use crate::common;
use crate::feed::pulses::Pulses;
use crate::feed::{self, HZ, Job, Line, MILLIS, Step, run, s_curve, steps_of, terms};
use crate::stream::Awake;
use stepwright::drive::BoardPin;
use stepwright_feeder::FeedState;
use stepwright_rig::Board;

/// While three axes move: the duty between two changes, and the lateness of each change.
#[test]
fn its_pulses_have_the_power_at_its_time() {
    if common::board() != Board::Mega {
        return;
    }
    let mut board = Awake::new();
    let pin = Board::Mega.pin(BoardPin::D(46)).unwrap();
    board.chip.watch_pins(&[pin]);
    let x = s_curve(30_000, 20_000.0, 40_000.0, 400_000.0);
    let axes: [Vec<Step>; 3] = [x.clone(), x.iter().step_by(2).copied().collect(), x];
    let powers = [(0.3, 255), (0.6, 0), (0.7, 26), (0.9, 128), (1.3, 230), (1.6, 0)];
    let job = Job::new(axes.clone()).with_laser(&powers);
    let told = run(&mut board, job, terms([40_000.0; 3]), Line { polls: true, ..Line::default() });
    assert_eq!(told.state, FeedState::Over);
    board.chip.run_to_silence(10_000_000, 500_000_000);
    let edges = board.chip.edges().to_vec();
    assert_eq!(
        [0, 1, 2].map(|axis| feed::position_of(&steps_of(&edges, axis))),
        [30_000, 15_000, 30_000]
    );
    let begin = steps_of(&edges, 0)[0].0 as f64 - axes[0][0].0 * HZ;
    let changes = board.chip.take_watched_changes();
    let changes = changes.into_iter().map(|(time, _, level)| (time, level)).collect();
    // The timer's output is high for one more of 256.
    let part = |power| if power == 0 { 0.0 } else { (f64::from(power) + 1.0) / 256.0 };
    Pulses { changes, period: 256 * 8 }.check(begin, &powers, part);
    assert!(board.chip.spare() > 0 && begin > MILLIS as f64);
}
