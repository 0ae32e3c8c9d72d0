//! The laser of a simulated Mega, by the level of its pin alone: D46, in pulses of 7.8 kHz.

use crate::common;
use crate::feed::{self, HZ, Job, Line, MILLIS, Step, run, s_curve, steps_of, terms};
use crate::stream::Awake;
use stepwright::drive::BoardPin;
use stepwright_feeder::FeedState;
use stepwright_rig::Board;

/// Cycles of a pulse and its pause.
const PERIOD: u64 = 256 * 8;

/// Of a period that begins at this cycle, the part in which the pin is high.
fn duty(changes: &[(u64, u8, bool)], from: u64) -> f64 {
    let to = from + 8 * PERIOD;
    let n = changes.partition_point(|change| change.0 <= from);
    let mut level = n.checked_sub(1).is_some_and(|n| changes[n].2);
    let (mut at, mut high) = (from, 0);
    for &(time, _, next) in changes[n..].iter().take_while(|change| change.0 < to) {
        high += if level { time - at } else { 0 };
        (at, level) = (time, next);
    }
    high += if level { to - at } else { 0 };
    high as f64 / (8 * PERIOD) as f64
}

/// The duty of a power: the timer is high for one more of 256.
fn part(power: u8) -> f64 {
    if power == 0 { 0.0 } else { (f64::from(power) + 1.0) / 256.0 }
}

/// While three axes move: the duty between two changes, and how late each of them comes.
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
    let at = |time: f64| (begin + time * HZ) as u64;
    let changes = board.chip.take_watched_changes();
    assert!(duty(&changes, at(0.1)) == 0.0 && duty(&changes, at(1.7)) == 0.0);
    for (n, (time, power)) in powers.into_iter().enumerate() {
        let next = powers.get(n + 1).map_or(time + 0.2, |next| next.0);
        let wanted = part(power);
        for place in [0.1, 0.5, 0.9] {
            let duty = duty(&changes, at(time + (next - time) * place));
            assert!((duty - wanted).abs() < 0.01, "{time}: {duty} of {wanted}");
        }
        // A pulse more, and two passes of the main loop.
        let (before, behind) =
            (duty(&changes, at(time) - 8 * PERIOD - 4_800), duty(&changes, at(time) + 4_800));
        let was = n.checked_sub(1).map_or(0, |n| powers[n].1);
        let was = part(was);
        assert!(
            (before - was).abs() < 0.05 && (behind - wanted).abs() < 0.05,
            "{time}: {before} {behind}"
        );
    }
    assert!(board.chip.spare() > 0 && at(0.0) > MILLIS);
}
