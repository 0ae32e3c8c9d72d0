//! Whole runs on the virtual board by a serial line, judged by its edges.

mod common;

use common::*;
use stepwright_feeder::FeedState;

/// The largest difference of an edge from its time, in µs; all axes share one beginning.
fn worst(told: &Told, job: &[Vec<Step>; 3], stagger: f64) -> f64 {
    let mut worst = [f64::MIN, f64::MAX];
    for axis in 0..3u8 {
        let steps = steps_of(&told.edges, axis);
        let wanted = &job[usize::from(axis)];
        assert_eq!(steps.len(), wanted.len(), "axis {axis}");
        for (made, wanted) in steps.iter().zip(wanted) {
            assert_eq!(made.1, wanted.1);
            let apart = made.0 as f64 - wanted.0 * HZ - stagger * f64::from(axis);
            worst = [worst[0].max(apart), worst[1].min(apart)];
        }
    }
    // Half of the spread: the beginning is any.
    (worst[0] - worst[1]) / 2.0 / 16.0
}

fn organic() -> [Vec<Step>; 3] {
    let waves = [(400.0, 1.0), (150.0, 3.1), (30.0, 9.7)];
    [wander(4.0, &waves, 0.0), wander(4.0, &waves, 1.9), wander(4.0, &[(20.0, 0.5)], 0.4)]
}

#[test]
fn three_axes_with_limited_jerk() {
    let axis = |v: f64| s_curve(40_000, v, 40_000.0, 400_000.0);
    let axes = [axis(30_000.0), axis(30_040.0), axis(30_080.0)];
    let told = run(Job::new(axes.clone()), terms([40_000.0; 3]), Line::default());
    assert_eq!((told.state, told.late, told.again), (FeedState::Over, 0, 0));
    assert_eq!(told.position, [Some(40_000); 3]);
    let worst = worst(&told, &axes, 75.0);
    println!("worst {worst:.2} us, {} bytes", told.bytes);
    // An edge waits for the pulse of another axis, 2 µs.
    assert!(worst < 7.1, "{worst}");
}

#[test]
fn a_motion_that_wanders_with_turns() {
    let axes = organic();
    let told = run(Job::new(axes.clone()), terms([40_000.0; 3]), Line::default());
    assert_eq!((told.state, told.late, told.again), (FeedState::Over, 0, 0));
    let worst = worst(&told, &axes, 75.0);
    println!("worst {worst:.2} us, {} bytes", told.bytes);
    // An edge waits for the pulse of another axis, 2 µs.
    assert!(worst < 7.1, "{worst}");
    for axis in 0..3u8 {
        let at = position_of(&steps_of(&told.edges, axis));
        assert_eq!(told.position[usize::from(axis)], Some(at));
    }
}

#[test]
fn spoilt_bytes_lose_no_step() {
    let axes = organic();
    for seed in 1..4 {
        let line = Line { spoils: 100, seed, polls: true, ..Line::default() };
        let told = run(Job::new(axes.clone()), terms([40_000.0; 3]), line);
        println!("seed {seed}: {:?}, again {}, answers {}", told.state, told.again, told.answers);
        assert_eq!((told.state, told.late), (FeedState::Over, 0), "seed {seed}");
        assert!(told.again > 5);
        // Where little was ahead steps are kept less closely.
        assert!(worst(&told, &axes, 75.0) < 27.1);
    }
}
