//! Routes with limited jerk, judged only by their steps.

use std::f64::consts::TAU;

use crate::jobs::{self, AXIS, Job};
use crate::judge::jerk::jerk_broken;
use crate::judge::{Axis, jump_needed};
use stepwright_path::{AxisPace, Route, Unplannable};

fn smooth(jerk: f64) -> Route<2> {
    Route::new([AxisPace { jerk, ..AXIS }; 2]).unwrap()
}

fn played<const N: usize>(route: &mut Route<N>, axes: &mut [Axis; N]) {
    for step in route.by_ref() {
        axes[step.axis].push((step.time, step.forward));
    }
}

/// The time of a job. Its steps have the same time, and keep the law of speed and the law of jerk.
pub fn judged(name: &str, job: &Job, jerk: f64) -> f64 {
    let planned = jobs::time(job, smooth(jerk));
    let (mut route, mut axes) = (smooth(jerk), [const { Vec::new() }; 2]);
    for (to, feed) in job {
        route.line_to(*to, *feed).unwrap();
        played(&mut route, &mut axes);
    }
    route.close();
    played(&mut route, &mut axes);
    assert!(route.is_over());
    let time = route.time();
    assert!(time == planned, "{name}: {time} s, planned {planned}");
    let end = job.last().unwrap().0;
    for (n, axis) in axes.iter().enumerate() {
        let at: i64 = axis.iter().map(|(_, forward)| if *forward { 1 } else { -1 }).sum();
        assert!((at as f64 * 0.0125 - end[n]).abs() <= 0.0125 * 0.501, "{at}");
        let (jump, at) = jump_needed(axis, AXIS.step, AXIS.accel, time);
        println!("{name}, {jerk}: {time:.3} s, axis {n} needs a jump of {jump:.3} at {at:.3} s");
        assert!(jump <= AXIS.jump, "{name}: axis {n} jumps by {jump} at {at} s");
        if jerk.is_infinite() {
            continue;
        }
        let broken = jerk_broken(axis, AXIS.step, [AXIS.jump, AXIS.accel, jerk], time);
        assert!(broken.is_none(), "{name}: axis {n} breaks the law of jerk at {broken:?} s");
    }
    time
}

/// The staircase has one S-curve per leg: from 5 mm/s over 10 mm and back, at 1000 mm/s² and 10,000 mm/s³. By
/// arithmetic it takes 12.05 s without acceleration at its corners, and 10.28 s with 316 mm/s², √(2·S·J).
/// Without acceleration at the joints of its chords it takes 29 s.
#[test]
fn an_acceleration_is_carried_over_joints() {
    let time = judged("staircase", &jobs::staircase(), 10_000.0);
    assert!(time <= 10.5, "{time}");
}

/// Corners are reached and left with an acceleration.
#[test]
fn corners_keep_the_law_of_jerk() {
    for (name, job, most) in
        [("lines", jobs::lines(), [262.0, 246.5]), ("raster", jobs::raster(), [48.7, 44.1])]
    {
        for (jerk, most) in [10_000.0, 50_000.0].into_iter().zip(most) {
            let time = jobs::time(&job, smooth(jerk));
            assert!(time <= most, "{name} at {jerk}: {time} s");
            judged(name, &job[..60].to_vec(), jerk);
        }
    }
}

#[test]
fn curves_keep_the_law_of_jerk() {
    for (name, job, most) in [
        ("arcs at 29", jobs::arcs(1_750.0 / 60.0), [8.78, 8.71]),
        ("circle", jobs::circle(100.0), [5.72, 5.60]),
        ("arcs at 100", jobs::arcs(100.0), [5.96, 4.42]),
        ("organic", jobs::organic(), [28.95, 26.2]),
    ] {
        for (jerk, most) in [10_000.0, 50_000.0].into_iter().zip(most) {
            let time = judged(name, &job, jerk);
            assert!(time <= most, "{name} at {jerk}: {time} s");
        }
    }
}

/// Chords that another planner passed at 337 and at 2,292 mm/s. A small change of the length must not change
/// the speed much.
#[test]
fn chords_of_nearly_one_length_take_nearly_one_time() {
    for (jerk, most) in [(10_000.0, 4.70), (50_000.0, 4.61)] {
        let [a, b] = [0.99, 1.0].map(|chord| judged("chords", &jobs::chords(chord), jerk));
        assert!((a / b - 1.0).abs() <= 0.002 && a.max(b) <= most, "{jerk}: {a} s, {b} s");
    }
}

/// From rest to rest a line is an S-curve. By arithmetic: to 100 mm/s in 0.2 s over 10 mm.
#[test]
fn a_line_by_hand() {
    let mut route = smooth(10_000.0);
    route.line_to([100.0, 0.0], 100.0).unwrap();
    route.close();
    let mut axes = [const { Vec::new() }; 2];
    played(&mut route, &mut axes);
    // At 0.99 of the jerk it takes 0.101 s to 1000 mm/s², and leads to 101 mm/s. So 100 mm/s takes
    // 2·√(100/9900).
    let ramp = 2.0 * (100.0f64 / 9_900.0).sqrt();
    let time = 2.0 * ramp + (100.0 - 100.0 * ramp) / 100.0;
    assert!((route.time() - time).abs() < 1e-9, "{} {time}", route.time());
    // In half of the ramp's time: J·t³/6.
    let place = 9_900.0 * (ramp / 2.0).powi(3) / 6.0;
    let count = axes[0].iter().filter(|step| step.0 <= ramp / 2.0).count();
    assert_eq!(count, (place / AXIS.step).round() as usize);
}

#[test]
fn a_hold_brakes_by_its_jerk_and_goes_on() {
    let mut route = smooth(10_000.0);
    route.line_to([100.0, 0.0], 50.0).unwrap();
    route.close();
    route.hold(1.0);
    let mut axes = [const { Vec::new() }; 2];
    played(&mut route, &mut axes);
    // From 50 mm/s in 2·√(50/9900).
    let rest = 1.0 + 2.0 * (50.0f64 / 9_900.0).sqrt();
    assert!(route.is_held() && (route.time() - rest).abs() < 1e-9, "{} {rest}", route.time());
    route.resume(3.0);
    // A hold while it speeds up: from a speed and an acceleration.
    route.hold(3.05);
    route.resume(4.0);
    route.scale(4.06, 0.5).unwrap();
    route.scale(4.5, 2.0).unwrap();
    played(&mut route, &mut axes);
    assert!(route.is_over() && route.positions() == [8_000, 0]);
    let broken = jerk_broken(&axes[0], AXIS.step, [0.1, 1_000.0, 10_000.0], route.time());
    assert_eq!(broken, None);
}

/// At nearly the highest speed at which it can turn, 120 mm/s. With what turning leaves to each axis where it
/// is aligned, the stop would be 6.7 mm later.
#[test]
fn a_hold_in_a_curve_brakes_as_on_a_circle() {
    let mut route = smooth(10_000.0);
    route.arc([0, 1], [20.0, 0.0], 1.2 * TAU, [0.0; 2], 200.0).unwrap();
    route.close();
    route.hold(0.6);
    let mut stands = 0.0;
    while let Some(stretch) = route.pass_over() {
        stands = stretch.way[1];
    }
    assert!(route.is_held() && stands < 82.0, "{stands}");
}

#[test]
fn what_makes_no_sense_is_refused() {
    for jerk in [0.0, -1.0, f64::NAN] {
        let refused = Route::new([AxisPace { jerk, ..AXIS }]).unwrap_err();
        assert_eq!(refused, Unplannable::Jerk);
    }
}

/// The law is sampled at fractions of √(jump / jerk). Without a least jump, planning three lines would take 4 s
/// with a jump of 10⁻⁹ mm/s, and four minutes with 10⁻¹².
#[test]
fn a_jump_that_is_next_to_none_is_planned_as_a_small_one() {
    let play = |jump: f64| {
        let axis = AxisPace { jump, jerk: 20_000.0, ..AXIS };
        let mut route = Route::new([axis; 2]).unwrap();
        for to in [[30.0, 0.0], [30.0, 20.0], [0.0, 0.0]] {
            route.line_to(to, 100.0).unwrap();
        }
        route.close();
        let steps: Vec<_> = route.by_ref().collect();
        (steps, route.time())
    };
    let (small, larger) = (play(2e-4), play(3e-4));
    assert!(small.1 > larger.1, "{} {}", small.1, larger.1);
    let least = play(1e-12);
    assert!(least == small, "{} {}", least.1, small.1);
}

/// X passes two corners of a jump each in 5.5 ms. Z stands, and its jerk is hidden sooner. Its settled state
/// must not make the law of jerk of X count as settled.
#[test]
fn a_quick_axis_that_stands_settles_no_other() {
    let axis = AxisPace { step: 0.0025, jerk: 10_000.0, ..AXIS };
    let quick = AxisPace { accel: 500.0, jump: 0.2, jerk: f64::INFINITY, ..axis };
    let times = [axis, quick].map(|z| {
        let mut route = Route::new([axis, axis, z]).unwrap();
        let (mut at, mut axes) = ([0.0; 3], [const { Vec::new() }; 3]);
        for (x, length) in [(-0.5f64, 10.0), (0.0, 9.4 * 0.0055), (0.5, 10.0)] {
            at = [at[0] + x * length, at[1] + (1.0 - x * x).sqrt() * length, 0.0];
            route.line_to(at, 9.4).unwrap();
        }
        route.close();
        played(&mut route, &mut axes);
        let time = route.time();
        for steps in &axes[..2] {
            let broken = jerk_broken(steps, axis.step, [axis.jump, axis.accel, axis.jerk], time);
            assert_eq!(broken, None, "Z has a jump of {}", z.jump);
        }
        time
    });
    assert!((times[0] / times[1] - 1.0).abs() < 0.01, "{times:?}");
}

/// So far from the beginning, by rounding, a part at constant speed may take no time and still lead on by the
/// last digit. It must not be passed again and again.
#[test]
fn a_far_route_ends() {
    let mut route = smooth(10_000.0);
    route.line_to([1e5, 0.0], 300.0).unwrap();
    route.close();
    while route.pass_over().is_some() {}
    for to in [
        [100_000.004_6, 0.0029],
        [100_000.003_8, 0.0024],
        [100_000.004_1, 0.0086],
        [99_999.991_1, -0.0041],
    ] {
        route.line_to(to, 44.0).unwrap();
    }
    route.close();
    let passed = std::iter::from_fn(|| route.pass_over()).take(20_000).count();
    assert!(passed < 20_000 && route.is_over());
}

/// A rest that rounding leaves where a curve meets itself is no piece, and makes no corner.
#[test]
fn what_is_next_to_nothing_is_no_piece() {
    for jerk in [f64::INFINITY, 10_000.0] {
        let circle = |closed: bool| {
            let mut route = smooth(jerk);
            for n in 1..=500 {
                let (sin, cos) = (TAU * f64::from(n) / 500.0).sin_cos();
                route.line_to([20.0 * cos - 20.0, 20.0 * sin], 100.0).unwrap();
            }
            if closed {
                route.line_to([0.0, 0.0], 100.0).unwrap();
            }
            for n in 1..=20 {
                route.line_to([0.0, 0.25 * f64::from(n)], 100.0).unwrap();
            }
            route.close();
            while route.pass_over().is_some() {}
            route.time()
        };
        assert_eq!(circle(true), circle(false), "{jerk}");
        let line = |sweep: f64| {
            let mut route = smooth(jerk);
            route.line_to([10.0, 0.0], 50.0).unwrap();
            if sweep > 0.0 {
                route.arc([0, 1], [10.0, 10.0], sweep, [0.0; 2], 50.0).unwrap();
            }
            route.line_to([20.0, 0.0], 50.0).unwrap();
            route.close();
            while route.pass_over().is_some() {}
            route.time()
        };
        for sweep in [1e-300, 1e-18, 1e-13, 1e-10] {
            assert_eq!(line(sweep), line(0.0), "{jerk}, {sweep}");
        }
        // Many of them together are a piece.
        let mut route = smooth(jerk);
        for n in 1..=1_000 {
            route.line_to([1e-8 * f64::from(n), 0.0], 50.0).unwrap();
        }
        assert!((route.length() - 1e-5).abs() < 2e-8, "{}", route.length());
        assert_eq!(route.arc([0, 1], [1.0, 0.0], 1e-18, [0.0; 2], 0.0), Err(Unplannable::Speed));
    }
}
