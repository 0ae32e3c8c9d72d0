//! Routes, judged only by their steps.

use crate::jobs::{self, AXIS, Job};
use crate::judge::{Axis, jump_needed};
use stepwright_path::Route;

/// Adds the steps that are final now to those of each axis.
fn played<const N: usize>(route: &mut Route<N>, axes: &mut [Axis; N]) {
    for step in route.by_ref() {
        axes[step.axis].push((step.time, step.forward));
    }
}

fn steps(job: &Job) -> ([Axis; 2], f64) {
    let mut route = Route::new([AXIS; 2]).unwrap();
    let mut axes = [const { Vec::new() }; 2];
    for (to, feed) in job {
        route.line_to(*to, *feed).unwrap();
        played(&mut route, &mut axes);
    }
    route.close();
    played(&mut route, &mut axes);
    assert!(route.is_over());
    let end = job.last().unwrap().0;
    for (axis, end) in axes.iter().zip(end) {
        let at: i64 = axis.iter().map(|(_, forward)| if *forward { 1 } else { -1 }).sum();
        assert!((at as f64 * 0.0125 - end).abs() <= 0.0125 * 0.501, "{at} {end}");
    }
    (axes, route.time())
}

/// The time of a job. Its steps have the same time, and keep the law of speed.
fn judged(name: &str, job: &Job) -> f64 {
    let planned = jobs::time(job, Route::new([AXIS; 2]).unwrap());
    let (axes, time) = steps(job);
    assert!((time - planned).abs() < 1e-9, "{name}: {time} s, planned {planned}");
    for (n, axis) in axes.iter().enumerate() {
        let (jump, at) = jump_needed(axis, AXIS.step, AXIS.accel, time);
        println!("{name}: {time:.3} s, axis {n} needs a jump of {jump:.3} at {at:.3} s");
        assert!(jump <= AXIS.jump * 1.001, "{name}: axis {n} jumps by {jump} at {at} s");
    }
    time
}

/// Circle, lines and raster have known times under a jump of 5 mm/s and 1000 mm/s² along the path, from a
/// planner of another kind. The limits here are those of each axis.
#[test]
fn the_jobs_take_their_times() {
    for (name, job, most) in [
        ("circle", jobs::circle(100.0), 5.57),
        ("organic", jobs::organic(), 24.1),
        ("lines", jobs::lines(), 248.6),
        ("raster", jobs::raster(), 43.3),
        ("staircase", jobs::staircase(), 7.63),
        ("arcs at 29", jobs::arcs(1_750.0 / 60.0), 8.65),
        ("arcs at 100", jobs::arcs(100.0), 4.5),
    ] {
        let time = judged(name, &job);
        assert!(time <= most, "{name}: {time} s");
    }
    let [a, b] = [0.99, 1.0].map(|chord| judged("chords", &jobs::chords(chord)));
    assert!((a / b - 1.0).abs() < 0.002, "{a} {b}");
}

/// A square of 50 mm with round corners of 10 mm, where lines and arcs meet smoothly: 60 mm/s from the first
/// ramp to the last, and no jump.
#[test]
fn smooth_joints_are_passed_at_speed() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let mut route = Route::new([AXIS; 2]).unwrap();
    for ([x, y], centre) in [
        ([30.0, 0.0], [30.0, 10.0]),
        ([40.0, 40.0], [30.0, 40.0]),
        ([0.0, 50.0], [0.0, 40.0]),
        ([-10.0, 10.0], [0.0, 10.0]),
    ] {
        route.line_to([x, y], 60.0).unwrap();
        route.arc([0, 1], centre, quarter, [0.0; 2], 60.0).unwrap();
    }
    // It brakes on a line: an arc leaves less acceleration for braking.
    route.line_to([10.0, 0.0], 60.0).unwrap();
    route.close();
    let mut axes = [const { Vec::new() }; 2];
    played(&mut route, &mut axes);
    let time = (4.0 * 30.0 + 4.0 * quarter * 10.0 + 10.0) / 60.0 + 0.06;
    assert!((route.time() - time).abs() < 1e-6, "{} {time}", route.time());
    assert_eq!(route.positions(), [800, 0]);
    for axis in &axes {
        let (jump, at) = jump_needed(axis, AXIS.step, AXIS.accel, time);
        assert!(jump < 0.01, "{jump} at {at}");
    }
}

/// Junction deviation is faster at corners, and does not limit the jump.
#[test]
fn junction_deviation_exceeds_the_axes() {
    let by_deviation = |job: &Job| {
        let mut axes = [const { Vec::new() }; 2];
        let mut route = Route::new([AXIS; 2]).unwrap().with_deviation(0.05).unwrap();
        for (to, feed) in job {
            route.line_to(*to, *feed).unwrap();
            played(&mut route, &mut axes);
        }
        route.close();
        played(&mut route, &mut axes);
        let time = route.time();
        (time, jump_needed(&axes[0], AXIS.step, AXIS.accel, time).0)
    };
    let (time, jump) = by_deviation(&jobs::organic());
    println!("organic with junction deviation: {time:.3} s, a jump of {jump:.1}");
    assert!(jump > 2.0 * AXIS.jump, "{jump}");
    let raster = jobs::raster();
    let (time, _) = by_deviation(&raster);
    println!("raster with junction deviation: {time:.3} s");
    assert!(time < judged("raster", &raster), "{time}");
}

/// A million chords of 0.05 mm: only the cells ahead are kept.
#[test]
fn memory_is_bounded() {
    let mut route = Route::new([AXIS; 2]).unwrap();
    let (mut most, mut ahead) = (0, 0usize);
    for n in 1..=1_000_000u32 {
        let x = f64::from(n) * 0.05;
        route.line_to([x, 10.0 * (x / 15.0).sin()], 200.0).unwrap();
        ahead += 1;
        while route.pass_over().is_some() {
            ahead = ahead.saturating_sub(1);
        }
        most = most.max(ahead);
    }
    // Braking from 283 mm/s along the path takes 40 mm, and every other half is planned.
    assert!(most < 4_000, "{most}");
}
