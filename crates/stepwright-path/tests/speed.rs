//! The speed of planning a route, as a ratio that is the same on slow and fast machines: the time per piece
//! over the time of a chain of roots and divisions, each of which waits for the one before.
//!
//! The stored ratios were measured in processor time. Twice the stored ratio fails; on a busy machine 1.5 times
//! was seen.

use std::hint::black_box;
use std::time::Instant;

use crate::jobs::{self, AXIS, Job, time};
use stepwright_path::{AxisPace, Route};

/// The links of the chain in a unit of time.
const LINKS: u32 = 1_000;

/// The runs of each measurement, of which the shortest counts.
const RUNS: usize = 7;

/// The processor time of this thread in s, or the clock's time where Linux does not report it: another program
/// may have the processor most of the time.
fn now(begun: Instant) -> f64 {
    // Linux reports it as of the last time that the thread gave way.
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanos = text.split(' ').next().and_then(|text| text.parse::<f64>().ok());
    nanos.map_or_else(|| begun.elapsed().as_secs_f64(), |nanos| nanos / 1e9)
}

/// The shortest time of several runs, in s.
fn shortest(mut work: impl FnMut()) -> f64 {
    let begun = Instant::now();
    let run = |_| {
        let before = now(begun);
        work();
        now(begun) - before
    };
    (0..RUNS).map(run).fold(f64::INFINITY, f64::min)
}

/// The time of a thousand links, in s.
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

/// A gentle curve in chords of this length.
fn wave(chord: f64) -> Job {
    let place = |n: u32| {
        let x = f64::from(n) * chord;
        ([x, 10.0 * (x / 15.0).sin()], 100.0)
    };
    (1..=20_000).map(place).collect()
}

/// Plans a job with a jerk, and compares the ratio with the stored one.
fn planning(name: &str, job: &Job, jerk: f64, stored: f64) {
    let axis = AxisPace { jerk, ..AXIS };
    let plan = || time(job, Route::new([axis; 2]).unwrap());
    let long = plan();
    // Between two measurements of the chain, of which the slower one counts.
    let before = unit();
    let whole = shortest(|| _ = black_box(plan()));
    let piece = whole / job.len() as f64;
    let ratio = piece / before.max(unit());
    let name = format!("{name}, a jerk of {jerk}");
    println!(
        "{name}: {:.0} ns a piece, {:.0} times as fast as it moves; {ratio:.4}, stored {stored}",
        piece * 1e9,
        long / whole
    );
    assert!(ratio < 2.0 * stored, "{name}: {ratio}, stored {stored}");
}

#[test]
fn planning_takes_as_long_as_it_did() {
    for (chord, [without, with]) in
        [(0.05, [0.040, 0.26]), (0.2, [0.043, 0.20]), (1.0, [0.044, 0.26])]
    {
        let (name, job) = (format!("chords of {chord} mm"), wave(chord));
        planning(&name, &job, f64::INFINITY, without);
        planning(&name, &job, 10_000.0, with);
    }
    // Places of three digits, which are judged over more than two chords.
    let rough = wave(0.05).into_iter();
    let rough = rough.map(|(to, feed)| (to.map(|to| (to * 1e3).round() / 1e3), feed)).collect();
    planning("rough chords of 0.05 mm", &rough, f64::INFINITY, 0.07);
    planning("rough chords of 0.05 mm", &rough, 10_000.0, 0.32);
    // Where many plans have to be tried.
    for (jerk, [arcs, organic]) in [(10_000.0, [0.93, 0.72]), (50_000.0, [0.82, 0.61])] {
        planning("half circles at 100 mm/s", &jobs::arcs(100.0), jerk, arcs);
        planning("organic", &jobs::organic(), jerk, organic);
    }
}

/// The law of jerk is sampled every few ms. A turn that lasts for hours settles, and is not sampled all the way.
#[test]
fn a_slow_turn_is_planned_as_a_fast_one() {
    let axis = AxisPace { jump: 0.01, jerk: 10_000.0, ..AXIS };
    let planned = |feed: f64| {
        shortest(|| {
            let mut route = Route::new([axis; 2]).unwrap();
            route.arc([0, 1], [20.0, 0.0], std::f64::consts::TAU, [0.0; 2], feed).unwrap();
            route.close();
            while route.pass_over().is_some() {}
            let lasts = route.length() / feed;
            assert!((route.time() - lasts).abs() < 0.1 + 1e-4 * lasts, "{} {lasts}", route.time());
        })
    };
    let [slow, fast] = [1.0 / 60.0, 10.0].map(planned);
    println!("1 mm/min takes {:.1} times as long to plan as 10 mm/s", slow / fast);
    assert!(slow < 2.0 * fast, "{slow} {fast}");
}
