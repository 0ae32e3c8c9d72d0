//! How fast a route is planned, as a ratio that is the same on a slow machine and a fast one:
//! time per piece over the time of a chain of roots and divisions, each of which waits for the one
//! before.
//!
//! The stored ratios are what was measured when they were written. Twice as long fails: on a busy
//! machine half as long again was seen.

mod jobs;

use std::hint::black_box;
use std::time::Instant;

use jobs::{AXIS, time};
use stepwright_path::{AxisPace, Route};

/// Links of the chain in a unit of time.
const LINKS: u32 = 1_000;

/// Runs of each, of which the shortest counts: another program may have the processor meanwhile.
const RUNS: usize = 15;

/// Seconds, at least.
fn shortest(mut work: impl FnMut()) -> f64 {
    let run = |_| {
        let begun = Instant::now();
        work();
        begun.elapsed().as_secs_f64()
    };
    (0..RUNS).map(run).fold(f64::INFINITY, f64::min)
}

/// Seconds of a thousand links.
fn unit() -> f64 {
    let chain = || {
        let mut x = black_box(2.0f64);
        for _ in 0..100 * LINKS {
            x = 1.0 + 1.0 / x.sqrt();
        }
        black_box(x);
    };
    shortest(chain) / 100.0
}

/// Chords of this length of a gentle curve, under a jerk, against the stored ratio.
fn planning(chord: f64, jerk: f64, stored: f64) {
    let place = |n: u32| {
        let x = f64::from(n) * chord;
        ([x, 10.0 * (x / 15.0).sin()], 100.0)
    };
    let job: jobs::Job = (1..=20_000).map(place).collect();
    let axis = AxisPace { jerk, ..AXIS };
    let plan = || _ = black_box(time(&job, Route::new([axis; 2]).unwrap()));
    // Between two looks at the chain, whose slower one counts.
    let before = unit();
    let piece = shortest(plan) / job.len() as f64;
    let ratio = piece / before.max(unit());
    let name = format!("chords of {chord} mm, a jerk of {jerk}");
    println!("{name}: {:.0} ns a piece, {ratio:.4}, stored {stored}", piece * 1e9);
    assert!(ratio < 2.0 * stored, "{name}: {ratio}, stored {stored}");
}

#[test]
fn planning_takes_as_long_as_it_did() {
    for (chord, stored) in [(0.05, 0.040), (0.2, 0.043), (1.0, 0.044)] {
        planning(chord, f64::INFINITY, stored);
    }
    for (chord, stored) in [(0.05, 0.9), (0.2, 1.0), (1.0, 1.4)] {
        planning(chord, 10_000.0, stored);
    }
}
