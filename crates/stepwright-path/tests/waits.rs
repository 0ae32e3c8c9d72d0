//! The times from the order of a hold until the route brakes and until it stands, with limited jerk: on random
//! paths of lines, arcs, smooth joints and chords in two and three unequal axes, at random times; and all along
//! a path of curves and corners.
//!
//! `STEPWRIGHT_HOLDS` sets the number of random paths. docs/paths.md has the figures of 400.

use stepwright_path::{AxisPace, Route};

use crate::jobs::{AXIS, Dice};
use crate::optimal::paths::{Kinds, Path};

/// The number of holds of each path.
const HOLDS: u32 = 8;

/// The distance by which a held route must differ from the same route without its hold, in units.
const OFF: f64 = 1e-8;

/// A part of a route with constant jerk, as it was passed.
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

    fn brakes(&self) -> bool {
        self.a + (self.end - self.begin) * self.jerk / 2.0 < 0.0
    }
}

/// The remaining parts of a route.
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

/// A route, and the parts that are passed without a hold.
struct Planned<const N: usize> {
    route: Route<N>,
    parts: Vec<Part>,
}

impl<const N: usize> Planned<N> {
    fn new(mut route: Route<N>) -> Planned<N> {
        route.close();
        // The route is planned when its first part is asked for.
        route.pass_over().unwrap();
        let parts = parts(route.clone());
        Planned { route, parts }
    }

    /// The times between which a hold may be ordered.
    fn times(&self) -> [f64; 2] {
        [self.parts[0].begin, self.parts[self.parts.len() - 1].end]
    }

    /// Holds the route at a time. Returns the time from then on in which it follows its plan and does not
    /// brake, and the time until it stands, in s.
    fn hold(&self, at: f64) -> [f64; 2] {
        let mut route = self.route.clone();
        route.hold(at);
        let held = parts(route);
        let mut known = 0;
        let as_planned = held.iter().take_while(|part| {
            while known + 1 < self.parts.len() && self.parts[known].end < part.end {
                known += 1;
            }
            (part.place(part.end) - self.parts[known].place(part.end)).abs() <= OFF
        });
        let late = as_planned.filter(|part| part.begin >= at && !part.brakes());
        let late = late.map(|part| part.end - part.begin).sum();
        [late, held.last().map_or(0.0, |part| part.end - at)]
    }
}

/// The mean, the 99th percentile and the largest value of both times are within these bounds.
fn judge(name: &str, holds: &[[f64; 2]], most: [[f64; 3]; 2]) {
    for (n, what) in ["does not brake for", "stands after"].into_iter().enumerate() {
        let mut all: Vec<f64> = holds.iter().map(|hold| hold[n]).collect();
        all.sort_by(f64::total_cmp);
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let (late, latest) = (all[all.len() * 99 / 100], all[all.len() - 1]);
        println!(
            "{name}, {} holds: it {what} {mean:.4} s in the mean, {late:.3} s at the 99th \
             percentile, {latest:.3} s at most",
            all.len()
        );
        let each = [mean, late, latest];
        assert!(
            each.iter().zip(most[n]).all(|(it, most)| *it <= most),
            "{name}: {what} {each:?} s"
        );
    }
}

fn hold_some<const N: usize>(seed: u64, jerk: f64) -> Vec<[f64; 2]> {
    let mut path: Path<N> = Path::random(seed, Kinds::All);
    path.axes = path.axes.map(|axis| AxisPace { jerk, ..axis });
    let mut route = Route::new(path.axes).unwrap();
    path.add_to(&mut route);
    let planned = Planned::new(route);
    let [begin, end] = planned.times();
    let mut dice = Dice(seed);
    (0..HOLDS).map(|_| planned.hold(begin + (end - begin) * dice.roll())).collect()
}

#[test]
fn holds_of_random_paths_are_as_soon_as_they_were() {
    let count = std::env::var("STEPWRIGHT_HOLDS")
        .map_or(120, |text| text.parse().expect("a number of paths"));
    for (jerk, most) in [
        (3_000.0, [[0.0078, 0.113, 0.165], [0.25, 0.56, 0.79]]),
        (10_000.0, [[0.0031, 0.062, 0.095], [0.15, 0.34, 0.54]]),
        (50_000.0, [[0.0004, 0.011, 0.04], [0.092, 0.25, 0.76]]),
    ] {
        let one = |seed: u64| {
            if seed.is_multiple_of(2) {
                hold_some::<2>(seed, jerk)
            } else {
                hold_some::<3>(seed, jerk)
            }
        };
        let holds: Vec<_> = (0..count).flat_map(one).collect();
        judge(&format!("random paths, a jerk of {jerk}"), &holds, most);
    }
}

/// Corners, a wave of chords, arcs, and corners close to each other. The holds come while the route turns,
/// speeds up, and before corners.
#[test]
fn a_hold_finds_a_stop() {
    for (jerk, most) in [
        (3_000.0, [[0.005, 0.075, 0.13], [0.215, 0.51, 0.57]]),
        (10_000.0, [[0.0026, 0.05, 0.09], [0.15, 0.35, 0.37]]),
        (50_000.0, [[0.0006, 0.018, 0.025], [0.07, 0.105, 0.115]]),
    ] {
        let mut route = Route::new([AxisPace { jerk, ..AXIS }; 2]).unwrap();
        for n in 1..=200 {
            let x = 0.2 * f64::from(n);
            route.line_to([x, 4.0 * (x / 3.0).sin()], 80.0).unwrap();
        }
        for n in 0..8 {
            let [x, y] = route.end();
            let sweep = if n % 2 == 0 { 3.1 } else { -3.1 };
            route.arc([0, 1], [x + 3.0, y], sweep, [0.0; 2], 60.0).unwrap();
            let [x, y] = route.end();
            route.line_to([x + 4.0, y + 1.0], 100.0).unwrap();
            route.line_to([x + 4.3, y - 0.2 * f64::from(n)], 100.0).unwrap();
        }
        let planned = Planned::new(route);
        let [begin, end] = planned.times();
        let count = ((end - begin) / 0.013) as u32;
        assert!(count > 300);
        let holds: Vec<_> =
            (0..count).map(|n| planned.hold(begin + 0.013 * f64::from(n))).collect();
        judge(&format!("one path, a jerk of {jerk}"), &holds, most);
    }
}
