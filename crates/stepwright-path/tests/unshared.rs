//! Compares routes with a planner of another kind: its limits apply along the path, and an axis that turns with
//! all of its acceleration may also speed up with all of it, as in most planners.
//!
//! ```text
//!   at a joint    v ≤ S/|Δt|  and  v² ≤ A·h/|Δt|      h: the mean of both pieces
//!   between       |v'| ≤ A
//! ```
//!
//! Its axes exceed their limits, and the judge measures by how much. A route has no such limits: each axis has
//! its acceleration only once. It is compared with a route whose axes jump by as much.

use crate::jobs::{self, AXIS, Job};
use crate::judge::{Axis, jump_needed};
use stepwright_path::{AxisPace, Route};

/// The time in s, and the jump that the steps need with the acceleration of the axes.
struct Judged {
    time: f64,
    jump: f64,
}

fn judged(axes: &[Axis; 2], time: f64) -> Judged {
    let jump = axes.iter().map(|axis| jump_needed(axis, AXIS.step, AXIS.accel, time).0);
    Judged { time, jump: jump.fold(0.0, f64::max) }
}

/// A route whose axes have this jump.
fn route(job: &Job, jump: f64) -> Judged {
    let mut route = Route::new([AxisPace { jump, ..AXIS }; 2]).unwrap();
    let mut axes = [const { Vec::new() }; 2];
    let mut take = |route: &mut Route<2>| {
        route.by_ref().for_each(|step| axes[step.axis].push((step.time, step.forward)));
    };
    for (to, feed) in job {
        route.line_to(*to, *feed).unwrap();
        take(&mut route);
    }
    route.close();
    take(&mut route);
    judged(&axes, route.time())
}

/// A piece of the other planner: its ends, its direction and length, and its speed.
struct Piece {
    from: [f64; 2],
    to: [f64; 2],
    way: [f64; 2],
    length: f64,
    feed: f64,
}

/// The other planner, with a jump of 5 mm/s of its axes at a joint.
fn unshared(job: &Job) -> Judged {
    let (mut pieces, mut from) = (Vec::new(), [0.0; 2]);
    for (to, feed) in job {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        if length > 1e-12 {
            let way = [0, 1].map(|n| (to[n] - from[n]) / length);
            pieces.push(Piece { from, to: *to, way, length, feed: *feed });
            from = *to;
        }
    }
    let a = AXIS.accel;
    let joint = |pair: &[Piece]| {
        let turn = [0, 1].map(|n| (pair[1].way[n] - pair[0].way[n]).abs());
        let (turn, h) = (turn[0].max(turn[1]).max(1e-12), (pair[0].length + pair[1].length) / 2.0);
        pair[0].feed.min(pair[1].feed).min(AXIS.jump / turn).powi(2).min(a * h / turn)
    };
    let mut w: Vec<f64> = pieces.windows(2).map(joint).chain([0.0]).collect();
    w.insert(0, 0.0);
    for n in (0..pieces.len()).rev() {
        w[n] = w[n].min(w[n + 1] + 2.0 * a * pieces[n].length);
    }
    for n in 0..pieces.len() {
        w[n + 1] = w[n + 1].min(w[n] + 2.0 * a * pieces[n].length);
    }
    let (mut axes, mut at, mut now) = ([const { Vec::new() }; 2], [0i64; 2], 0.0);
    for (piece, ends) in pieces.iter().zip(w.windows(2)) {
        let (from, to) = (ends[0], ends[1]);
        let peak = ((from + to) / 2.0 + a * piece.length).min(piece.feed.powi(2)).max(from).max(to);
        let (rise, fall) = ((peak - from) / 2.0 / a, (peak - to) / 2.0 / a);
        let level = (piece.length - rise - fall).max(0.0);
        let [first, top, last] = [from, peak, to].map(f64::sqrt);
        let time = (2.0 * top - first - last) / a + level / top;
        // Each ramp from its slower end.
        let ramp = |v: f64, way: f64| {
            if way > 0.0 { 2.0 * way / (v + (v * v + 2.0 * a * way).sqrt()) } else { 0.0 }
        };
        let when = |s: f64| match s {
            s if s <= rise => ramp(first, s),
            s if s <= rise + level => (top - first) / a + (s - rise) / top,
            s => time - ramp(last, piece.length - s),
        };
        for axis in 0..2 {
            while (piece.to[axis] / AXIS.step - at[axis] as f64).abs() > 0.5 {
                let forward = piece.to[axis] / AXIS.step > at[axis] as f64;
                let half = if forward { 0.5 } else { -0.5 };
                let place = (at[axis] as f64 + half) * AXIS.step - piece.from[axis];
                axes[axis].push((now + when((place / piece.way[axis]).max(0.0)), forward));
                at[axis] += if forward { 1 } else { -1 };
            }
        }
        now += time;
    }
    judged(&axes, now)
}

/// The other planner has its times of docs/paths.md, and its axes exceed their limits.
#[test]
fn what_is_not_shared_exceeds_the_axes() {
    for (name, job, time, jump) in [
        ("organic", jobs::organic(), 23.478, 10.2),
        ("arcs at 100", jobs::arcs(100.0), 3.812, 13.2),
        ("chords", jobs::chords(1.0), 4.207, 47.4),
    ] {
        let (other, ours) = (unshared(&job), route(&job, AXIS.jump));
        println!(
            "{name}: {:.3} s, needs {:.2}; a route {:.3} s",
            other.time, other.jump, ours.time
        );
        assert!((other.time - time).abs() < 0.001 && (other.jump - jump).abs() < 0.1, "{name}");
        assert!(ours.jump <= AXIS.jump && ours.time < other.time * 1.04, "{name}: {}", ours.time);
    }
}

/// With axes that jump by as much, a route makes the organic job in 24.1 s.
#[test]
fn axes_that_jump_as_far_are_about_as_fast() {
    let found = route(&jobs::organic(), 9.5);
    println!("organic, axes that jump by 9.5: {:.3} s, needs {:.2}", found.time, found.jump);
    assert!(found.time <= 24.1 && found.jump <= 9.5, "{} {}", found.time, found.jump);
}

/// A larger jump makes no job slower.
#[test]
fn a_larger_jump_costs_no_time() {
    for (name, job) in [
        ("organic", jobs::organic()),
        ("arcs at 100", jobs::arcs(100.0)),
        ("chords", jobs::chords(1.0)),
        ("circle", jobs::circle(100.0)),
    ] {
        let mut before = f64::INFINITY;
        for jump in [3.0, 4.0, 5.0, 6.0, 7.0, 9.5, 12.0, 20.0] {
            let time = jobs::time(&job, Route::new([AxisPace { jump, ..AXIS }; 2]).unwrap());
            assert!(time <= before * 1.000_1, "{name}: {time} s with {jump}, not {before}");
            before = time;
        }
    }
}
