//! How soon after its order a hold begins to brake, and stands, on random paths with limited jerk: lines,
//! arcs, smooth joints and chords in two and three unequal axes, held at random times.
//!
//! `STEPWRIGHT_HOLDS` says on how many paths; docs/paths.md has the figures of 400.

use stepwright_path::{AxisPace, Route};

use crate::jobs::Dice;
use crate::optimal::paths::{Kinds, Path};

/// Holds of each path.
const HOLDS: u32 = 8;

/// Units by which a held route must be off the same route without its hold.
const OFF: f64 = 1e-8;

/// A part of constant jerk, as it was passed.
struct Part {
    begin: f64,
    end: f64,
    s: f64,
    v: f64,
    a: f64,
    jerk: f64,
}

impl Part {
    fn place(&self, t: f64) -> f64 {
        let t = t - self.begin;
        self.s + t * (self.v + t * (self.a / 2.0 + t * self.jerk / 6.0))
    }
}

/// What is left of a route.
fn parts<const N: usize>(mut route: Route<N>) -> Vec<Part> {
    let mut parts = Vec::new();
    while let Some(stretch) = route.pass_over() {
        let [from, middle, to] = stretch.speeds;
        let mut s = stretch.way[0];
        for (n, [v, next]) in [[from, middle], [middle; 2], [middle, to]].into_iter().enumerate() {
            let (begin, end, way) = (stretch.times[n], stretch.times[n + 1], stretch.ways[n]);
            let long = end - begin;
            if long > 0.0 {
                let mean = (next - v) / long;
                let jerk = 6.0 * (mean - 2.0 * (way / long - v) / long) / long;
                parts.push(Part { begin, end, s, v, a: mean - jerk * long / 2.0, jerk });
            }
            s += way;
        }
    }
    parts
}

/// Adds, of each hold of a path, the seconds from its order to where the route leaves its plan, and
/// to where it stands.
fn hold_some<const N: usize>(seed: u64, jerk: f64, holds: &mut [Vec<f64>; 2]) {
    let mut path: Path<N> = Path::random(seed, Kinds::All);
    path.axes = path.axes.map(|axis| AxisPace { jerk, ..axis });
    let mut route = Route::new(path.axes).unwrap();
    path.add_to(&mut route);
    route.close();
    let begin = route.pass_over().unwrap().end();
    let planned = parts(route.clone());
    let end = planned.last().unwrap().end;
    let mut dice = Dice(seed);
    for _ in 0..HOLDS {
        let at = begin + (end - begin) * dice.roll();
        let mut held = route.clone();
        held.hold(at);
        let held = parts(held);
        let mut known = 0;
        let leaves = held.iter().find(|part| {
            while known + 1 < planned.len() && planned[known].end < part.end {
                known += 1;
            }
            (part.place(part.end) - planned[known].place(part.end)).abs() > OFF
        });
        // Near its end it stands there.
        holds[0].push(leaves.map_or(0.0, |part| (part.begin - at).max(0.0)));
        holds[1].push(held.last().map_or(0.0, |part| part.end - at));
    }
}

#[test]
fn holds_of_random_paths_begin_and_end_as_soon_as_they_did() {
    let count = std::env::var("STEPWRIGHT_HOLDS")
        .map_or(40, |text| text.parse().expect("a number of paths"));
    for (jerk, most) in [
        (3_000.0, [[0.022, 0.35], [0.26, 0.75]]),
        (10_000.0, [[0.0095, 0.25], [0.15, 0.52]]),
        (50_000.0, [[0.0062, 0.18], [0.085, 0.31]]),
    ] {
        let mut holds = [const { Vec::new() }; 2];
        for seed in 0..count {
            if u64::is_multiple_of(seed, 2) {
                hold_some::<2>(seed, jerk, &mut holds);
            } else {
                hold_some::<3>(seed, jerk, &mut holds);
            }
        }
        for ((name, mut all), most) in
            ["leaves its plan", "stands"].into_iter().zip(holds).zip(most)
        {
            all.sort_by(f64::total_cmp);
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            let (late, latest) = (all[all.len() * 99 / 100], all[all.len() - 1]);
            println!(
                "a jerk of {jerk}, {} holds: it {name} after {mean:.4} s in the mean, {late:.3} s at \
                 the 99th percentile, {latest:.3} s at the latest",
                all.len()
            );
            assert!(mean <= most[0] && latest <= most[1], "{name}: {mean} s, {latest} s");
        }
    }
}
