//! Lines and arcs that replace chords, judged only by the steps and the chords.

use std::f64::consts::TAU;

use crate::jobs::{self, AXIS, Dice, Job};
use crate::judge::jerk::jerk_broken;
use crate::judge::{Axis, jump_needed};
use stepwright_path::{ArcFit, AxisPace, Route, Unplannable};

/// A step: its time, its place along the route, and the places of the axes then, in mm.
type Point<const N: usize> = (f64, f64, [f64; N]);

/// The result of a job.
struct Made<const N: usize> {
    axes: [Axis; N],
    points: Vec<Point<N>>,
    /// The end of each chord along the route.
    ends: Vec<f64>,
    time: f64,
}

/// Chords: the end of each, and its feed.
type Chords<const N: usize> = Vec<([f64; N], f64)>;

fn made<const N: usize>(chords: &Chords<N>, pace: AxisPace, tolerance: f64) -> Made<N> {
    let mut route = Route::new([pace; N]).unwrap();
    let mut fit = ArcFit::new(tolerance).unwrap();
    let (mut at, mut ends) = ([0i64; N], Vec::new());
    let (mut axes, mut points) = ([const { Vec::new() }; N], vec![(0.0, 0.0, [0.0; N])]);
    let mut play = |route: &mut Route<N>| {
        while let Some(step) = route.next() {
            axes[step.axis].push((step.time, step.forward));
            at[step.axis] += if step.forward { 1 } else { -1 };
            points.push((step.time, route.along(step.time).0, at.map(|at| at as f64 * pace.step)));
        }
    };
    for (n, (to, feed)) in chords.iter().enumerate() {
        fit.line_to(&mut route, *to, *feed, n).unwrap();
        assert!(fit.waiting() <= 64);
        play(&mut route);
    }
    fit.settle(&mut route).unwrap();
    route.close();
    play(&mut route);
    assert!(route.is_over() && fit.waiting() == 0);
    while let Some((way, n)) = fit.settled() {
        assert_eq!(n, ends.len());
        ends.push(way);
    }
    assert_eq!((ends.len(), ends.last()), (chords.len(), Some(&route.length())));
    Made { axes, points, ends, time: route.time() }
}

/// The distance of a place from the line between two others.
fn off<const N: usize>(place: &[f64; N], [a, b]: [&[f64; N]; 2]) -> f64 {
    let way =
        |from: &[f64; N], to: &[f64; N]| -> [f64; N] { std::array::from_fn(|n| to[n] - from[n]) };
    let dot = |a: &[f64; N], b: &[f64; N]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (all, to) = (way(a, b), way(a, place));
    let part = (dot(&to, &all) / dot(&all, &all).max(1e-30)).clamp(0.0, 1.0);
    let foot = std::array::from_fn(|n| a[n] + part * all[n]);
    dot(&way(&foot, place), &way(&foot, place)).sqrt()
}

/// Chords of curves, lines and corners, with rounded places, reversals and tiny chords.
fn chain<const N: usize>(dice: &mut Dice) -> Chords<N> {
    let grid =
        if dice.roll() < 0.7 { [0.01, 0.001, 0.05][(3.0 * dice.roll()) as usize] } else { 1e-9 };
    let (mut at, mut heading, mut chords) = ([0.0; N], TAU * dice.roll(), Vec::new());
    for _ in 0..6 {
        let feed = 10.0 + 140.0 * dice.roll();
        // In X and Y, or in X and the last axis.
        let plane = [0, if dice.roll() < 0.7 { 1 } else { N - 1 }];
        let (chord, kind) = (0.02 * 50f64.powf(dice.roll()), dice.roll());
        let bend = match kind {
            _ if kind < 0.6 => chord / (0.5 * 100f64.powf(dice.roll())),
            _ if kind < 0.8 => 0.0,
            _ => 1.0,
        };
        let sign = if dice.roll() < 0.5 { 1.0 } else { -1.0 };
        for _ in 0..(1.0 + 80.0 * dice.roll()) as usize {
            heading += if bend == 1.0 { TAU * dice.roll() } else { sign * bend };
            at[plane[0]] += chord * heading.cos();
            at[plane[1]] += chord * heading.sin();
            if N > 2 && kind > 0.97 {
                at[N - 1] += chord * dice.roll();
            }
            chords.push((at.map(|place| (place / grid).round() * grid), feed));
        }
        if dice.roll() < 0.5 {
            heading = TAU * dice.roll();
        }
    }
    chords
}

/// Every position is within the tolerance of the chords, and every chord within the tolerance of the positions.
/// The end of each chord is known as exactly as steps can tell.
fn is_near<const N: usize>(seed: u64) {
    let mut dice = Dice(seed);
    let chords: Chords<N> = chain(&mut dice);
    let tolerance = 0.001 * 100f64.powf(dice.roll());
    // At most three quarters of a step of each axis: a turn within that makes no step.
    let pace = AxisPace { step: 0.005, ..AXIS };
    let near = tolerance + 0.75 * pace.step * (N as f64).sqrt() + 1e-9;
    let Made { points, ends, .. } = made(&chords, pace, tolerance);
    let places: Vec<_> = [[0.0; N]].into_iter().chain(chords.iter().map(|chord| chord.0)).collect();
    // Only a chord and its neighbours along the route count: other parts of the path may lead past the place.
    let mut first = 0;
    for (_, way, place) in &points {
        while first < ends.len() && ends[first] < way - 4.0 * near {
            first += 1;
        }
        let last = first + ends[first..].iter().take_while(|end| **end < way + 4.0 * near).count();
        let last = last.min(chords.len() - 1);
        let least = (first..=last).map(|n| off(place, [&places[n], &places[n + 1]]));
        let least = least.fold(f64::INFINITY, f64::min);
        assert!(least <= near, "seed {seed}: {place:?} is {least} off, with {tolerance}");
    }
    let mut last = 0;
    for (end, place) in ends.iter().zip(&places[1..]) {
        while last + 1 < points.len() && points[last + 1].1 <= *end {
            last += 1;
        }
        let off = off(place, [&points[last].2, &points[(last + 1).min(points.len() - 1)].2]);
        assert!(
            off <= near + 2.0 * pace.step,
            "seed {seed}: {place:?} ends {off} off, with {tolerance}"
        );
    }
}

#[test]
fn the_path_stays_within_the_tolerance() {
    // In the last job, a bulge that each place allows by itself is too large for one of them.
    for seed in (0..150).chain([15_094]) {
        is_near::<2>(seed);
        is_near::<3>(seed);
    }
}

/// Fitted routes keep the law of speed and the law of jerk.
#[test]
fn arcs_in_place_of_chords_keep_the_law() {
    for seed in 0..40 {
        let mut dice = Dice(seed);
        let chords: Chords<2> = chain(&mut dice);
        for jerk in [f64::INFINITY, 50_000.0, 10_000.0] {
            let pace = AxisPace { jerk, ..AXIS };
            let Made { axes, time, .. } = made(&chords, pace, 0.002 * 10f64.powf(dice.roll()));
            for axis in &axes {
                let (jump, at) = jump_needed(axis, pace.step, pace.accel, time);
                assert!(
                    jump <= pace.jump * (1.0 + 1e-9),
                    "seed {seed}, {jerk}: a jump of {jump} at {at} s"
                );
                if jerk.is_finite() {
                    let law = [pace.jump, pace.accel, jerk];
                    let broken = jerk_broken(axis, pace.step, law, time);
                    assert_eq!(broken, None, "seed {seed}, {jerk}");
                }
            }
        }
    }
}

fn rounded(job: &Job, grid: f64) -> Chords<2> {
    job.iter().map(|(to, feed)| (to.map(|place| (place / grid).round() * grid), *feed)).collect()
}

/// A circle of 20 mm in chords of 0.1 mm.
fn circle() -> Job {
    let place = |n: u32| (TAU * f64::from(n) / 1_257.0).sin_cos();
    let place = |n: u32| (20.0 * place(n).1 - 20.0, 20.0 * place(n).0);
    (1..=1_257).map(|n| ([place(n).0, place(n).1], 100.0)).collect()
}

/// Places with two digits take as long as exact places, with a tolerance of 0.01.
#[test]
fn rounded_places_take_no_longer_with_a_tolerance() {
    // The times as exact chords, as rounded chords, and as arcs that replace them.
    for (name, job, times) in [
        ("circle", circle(), [[1.357, 3.0, 1.357], [1.469, 4.4, 1.469]]),
        ("half circles", jobs::arcs(100.0), [[3.95, 6.4, 4.12], [5.96, 8.2, 5.94]]),
    ] {
        for (jerk, [exact, rough, fitted]) in [f64::INFINITY, 10_000.0].into_iter().zip(times) {
            let pace = AxisPace { jerk, ..AXIS };
            let two = rounded(&job, 0.01);
            let times = [made(&job, pace, 0.0), made(&two, pace, 0.0), made(&two, pace, 0.01)];
            let times = times.map(|made| made.time);
            println!("{name}, {jerk}: {times:?}");
            assert!(times[0] <= exact && times[1] >= rough && times[2] <= fitted, "{times:?}");
        }
    }
}

/// A tolerance below the rounding of places fits few chords, and costs little time.
#[test]
fn a_small_tolerance_costs_little() {
    let two = rounded(&circle(), 0.01);
    let [none, small] = [0.0, 0.002].map(|tolerance| made(&two, AXIS, tolerance).time);
    assert!(small <= 1.14 * none, "{small} s, and {none} s without");
}

/// Corners of longer lines stay corners, and the chords of a line become one line: a staircase takes as long as
/// its legs.
#[test]
fn corners_are_corners() {
    let legs: Chords<2> = jobs::staircase().into_iter().skip(49).step_by(50).collect();
    for jerk in [f64::INFINITY, 10_000.0] {
        let pace = AxisPace { jerk, ..AXIS };
        let stairs = made(&jobs::staircase(), pace, 0.05);
        let legs = made(&legs, pace, 0.0);
        assert!((stairs.time - legs.time).abs() < 1e-9, "{} {}", stairs.time, legs.time);
        // Both make the same steps.
        assert_eq!(stairs.points.len(), legs.points.len());
        let same = |(a, b): (&Point<2>, &Point<2>)| (a.0 - b.0).abs() < 1e-9 && a.2 == b.2;
        assert!(stairs.points.iter().zip(&legs.points).all(same));
    }
}

#[test]
fn what_makes_no_sense_is_refused_and_what_waits_stays() {
    for tolerance in [-1.0, f64::NAN, f64::INFINITY, 1e-13] {
        let refused = ArcFit::<(), 2>::new(tolerance).unwrap_err();
        assert_eq!(refused, Unplannable::Tolerance);
    }
    let mut route = Route::new([AXIS; 2]).unwrap();
    let mut fit = ArcFit::new(0.01).unwrap();
    let mut line = |fit: &mut ArcFit<u8, 2>, to, feed, tag| fit.line_to(&mut route, to, feed, tag);
    assert_eq!(line(&mut fit, [f64::NAN, 0.0], 50.0, 0), Err(Unplannable::TooLong));
    assert_eq!(line(&mut fit, [1.0, 0.0], f64::NAN, 1), Err(Unplannable::Speed));
    for n in 2..5 {
        line(&mut fit, [f64::from(n), 0.0], 50.0, n).unwrap();
    }
    assert_eq!(line(&mut fit, [9.0, f64::INFINITY], 50.0, 5), Err(Unplannable::TooLong));
    // A chord of no length has its tag, too.
    line(&mut fit, [4.0, 0.0], 50.0, 6).unwrap();
    line(&mut fit, [5.0, 0.0], 50.0, 7).unwrap();
    assert_eq!(fit.set_tolerance(&mut route, f64::NAN), Err(Unplannable::Tolerance));
    assert_eq!((fit.waiting(), route.end()), (1, [4.0, 0.0]));
    fit.set_tolerance(&mut route, 0.0).unwrap();
    let settled: Vec<_> = std::iter::from_fn(|| fit.settled()).collect();
    assert_eq!(settled, [(2.0, 2), (3.0, 3), (4.0, 4), (4.0, 6), (5.0, 7)]);
    // Chords that wait can be dropped.
    fit.set_tolerance(&mut route, 0.01).unwrap();
    fit.line_to(&mut route, [6.0, 0.0], 50.0, 8).unwrap();
    fit.clear();
    fit.settle(&mut route).unwrap();
    assert_eq!((fit.settled(), route.end()), (None, [5.0, 0.0]));
}
