//! Circles in chords as programs write them: with places of three digits after the point, and with short chords
//! between longer ones. They take as long as exact ones, and keep the laws.

use std::f64::consts::TAU;

use crate::jobs::{self, AXIS, Job};
use crate::smooth_routes::judged;
use stepwright_path::{AxisPace, Route};

const JERKS: [f64; 3] = [f64::INFINITY, 50_000.0, 10_000.0];

/// A circle through 0, in chords of these lengths in turn, with places rounded to multiples of `grid`.
fn circle(radius: f64, feed: f64, chords: &[f64], grid: f64) -> Job {
    let round = |place: f64| if grid > 0.0 { (place / grid).round() * grid } else { place };
    let (mut angle, mut job) = (0.0, Vec::new());
    for chord in chords.iter().cycle() {
        angle += chord / radius;
        if angle > TAU {
            break;
        }
        let place = [radius * angle.cos() - radius, radius * angle.sin()];
        job.push((place.map(round), feed));
    }
    job
}

/// If only the two chords at a joint counted, chords of 0.1 mm would take 1.9 times as long with a jerk of
/// 10,000 mm/s³, and chords of 0.05 mm 3.4 times.
#[test]
fn rounded_places_take_no_longer() {
    for (radius, feed, chord, grid, most) in [
        (20.0, 100.0, 0.1, 0.001, [1.002; 3]),
        (20.0, 100.0, 0.2, 0.001, [1.002; 3]),
        (100.0, 100.0, 0.1, 0.001, [1.002; 3]),
        (20.0, 100.0, 0.05, 0.001, [1.002; 3]),
        (20.0, 50.0, 0.2, 0.01, [1.004, 1.01, 1.035]),
    ] {
        for (jerk, most) in JERKS.into_iter().zip(most) {
            let name = format!("{radius} mm, chords of {chord}, {grid}");
            let [exact, rounded] = [0.0, grid].map(|grid| {
                let job = circle(radius, feed, &[chord], grid);
                judged(&name, &job, jerk)
            });
            assert!(rounded <= most * exact, "{name}, {jerk}: {rounded} s, not {exact}");
        }
    }
}

/// Short chords like those left where a curve is divided. By itself, each would be passed as a bend tighter by
/// as much, in up to 2.4 times the time.
#[test]
fn short_chords_between_longer_ones_take_no_longer() {
    for (radius, feed, most) in
        [(20.0, 100.0, [1.002; 3]), (50.0, 100.0, [1.002; 3]), (5.0, 50.0, [1.03, 1.06, 1.09])]
    {
        let mut chords = [0.5; 10];
        chords[9] = 0.02;
        for (jerk, most) in JERKS.into_iter().zip(most) {
            let name = format!("{radius} mm");
            let even = judged(&name, &circle(radius, feed, &[0.5], 0.0), jerk);
            let short = judged(&name, &circle(radius, feed, &chords, 0.0), jerk);
            assert!(short <= most * even, "{name}, {jerk}: {short} s, not {even}");
        }
    }
}

/// Junction deviation limits corners in place of the jump, also with places of two digits. It limits curves as
/// without it.
#[test]
fn so_do_they_by_junction_deviation() {
    for jerk in JERKS {
        let time = |grid: f64| {
            let route = Route::new([AxisPace { jerk, ..AXIS }; 2]).unwrap();
            let route = route.with_deviation(0.01).unwrap();
            jobs::time(&circle(20.0, 100.0, &[0.2], grid), route)
        };
        let [exact, rounded] = [0.0, 0.01].map(time);
        assert!(rounded <= 1.02 * exact, "{jerk}: {rounded} s, not {exact}");
    }
}

/// Passes of 40 mm over a bump, with a slow Z. If only two chords counted, they would take 1.45 times as long
/// as with exact places, and 1.9 times with limited jerk.
#[test]
fn passes_over_a_surface_take_little_longer() {
    let time = |grid: f64, jerk: f64| {
        let z = AxisPace { step: 0.0025, speed: 20.0, accel: 100.0, jump: 1.0, jerk: jerk / 10.0 };
        let axis = AxisPace { jerk, ..AXIS };
        let mut route = Route::new([axis, axis, z]).unwrap();
        let round = |place: f64| if grid > 0.0 { (place / grid).round() * grid } else { place };
        for row in 0..6 {
            for n in 0..=400 {
                let way = 0.1 * f64::from(n);
                let x = if row % 2 == 0 { way } else { 40.0 - way };
                let z = 3.0 * (-((x - 20.0) / 8.0).powi(2)).exp();
                route.line_to([x, 0.5 * f64::from(row), z].map(round), 50.0).unwrap();
            }
        }
        route.close();
        while route.pass_over().is_some() {}
        route.time()
    };
    for (jerk, most) in JERKS.into_iter().zip([1.011, 1.018, 1.035]) {
        let [exact, rounded] = [0.0, 0.001].map(|grid| time(grid, jerk));
        println!("surface, {jerk}: {exact:.3} {rounded:.3}");
        assert!(rounded <= most * exact, "{jerk}: {rounded} s, not {exact}");
    }
}
