//! Judges by its steps whether an axis stays within S/2 of a speed u with |u'| ≤ A and |u''| ≤ J.
//!
//! The set of all (u, u') that such a speed can have now is convex. It is kept as a polygon, and updated from
//! one mean speed to the next:
//!
//! ```text
//!   later   (u, a) → (u + a·T, a)              and the lens that |u''| ≤ J reaches in T
//!   seen    |u − v| ≤ S/2 + J·Δ²/24            a mean over Δ is that near to the speed in its middle,
//!                                              and what that mean is uncertain by
//!           |a| ≤ A
//! ```
//!
//! If the set is empty, there is no such speed. The lens is replaced by the hexagon around it, and surplus
//! corners are removed outwards. The set is therefore never too small: a motion that is refused certainly
//! breaks the law. A motion that breaks it by little may pass.

use super::{Axis, Mean, means};

type Corner = [f64; 2];

/// The most corners of the polygon.
const MOST: usize = 48;

/// The part of a convex polygon where `over` is at most 0.
fn clip(polygon: &[Corner], over: impl Fn(&Corner) -> f64) -> Vec<Corner> {
    let mut left = Vec::with_capacity(polygon.len() + 1);
    for (n, corner) in polygon.iter().enumerate() {
        let next = &polygon[(n + 1) % polygon.len()];
        let (here, there) = (over(corner), over(next));
        if here <= 0.0 {
            left.push(*corner);
        }
        if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
            let part = here / (here - there);
            left.push([0, 1].map(|n| corner[n] + (next[n] - corner[n]) * part));
        }
    }
    left
}

fn cross(a: Corner, b: Corner, c: Corner) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The convex hull, counterclockwise.
fn hull(mut corners: Vec<Corner>) -> Vec<Corner> {
    corners.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    corners.dedup();
    if corners.len() < 3 {
        return corners;
    }
    let mut hull: Vec<Corner> = Vec::new();
    for half in 0..2 {
        let begin = hull.len();
        for n in 0..corners.len() {
            let corner = corners[if half == 0 { n } else { corners.len() - 1 - n }];
            while hull.len() >= begin + 2
                && cross(hull[hull.len() - 2], hull[hull.len() - 1], corner) <= 0.0
            {
                hull.pop();
            }
            hull.push(corner);
        }
        hull.pop();
    }
    hull
}

/// Fewer corners around the same set: the edge whose removal adds the smallest area is removed, and the edges
/// on both sides are extended until they meet.
fn simpler(mut polygon: Vec<Corner>) -> Vec<Corner> {
    while polygon.len() > MOST {
        let count = polygon.len();
        let at = |n: usize| polygon[n % count];
        let meet = |n: usize| {
            let (a, b, c, d) = (at(n + count - 1), at(n), at(n + 1), at(n + 2));
            let (p, q) = ([b[0] - a[0], b[1] - a[1]], [c[0] - d[0], c[1] - d[1]]);
            let area = p[0] * q[1] - p[1] * q[0];
            let t = ((d[0] - a[0]) * q[1] - (d[1] - a[1]) * q[0]) / area;
            // Both edges lead to this corner; otherwise they do not meet on this side.
            let corner = [a[0] + p[0] * t, a[1] + p[1] * t];
            (t >= 1.0 && corner[0].is_finite()).then(|| (cross(b, corner, c).abs(), corner))
        };
        let best = (0..count).filter_map(|n| meet(n).map(|(cost, corner)| (cost, n, corner)));
        let Some((_, n, corner)) = best.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        polygon[n] = corner;
        polygon.remove((n + 1) % count);
    }
    polygon
}

/// The set after a time.
fn later(set: &[Corner], time: f64, jerk: f64) -> Vec<Corner> {
    // The ends of the lens, and the points where the tangents at its ends and in its middle meet.
    let (u, a) = (jerk * time * time / 2.0, jerk * time);
    let lens = [[u, a], [u, a / 2.0], [0.0, -a / 2.0], [-u, -a], [-u, -a / 2.0], [0.0, a / 2.0]];
    let moved = set.iter().map(|[u, a]| [u + a * time, *a]);
    hull(moved.flat_map(|[u, a]| lens.map(|[x, y]| [u + x, a + y])).collect())
}

/// The part of the set in which u is within `near` of v and |u'| ≤ `accel`.
fn seen(set: &[Corner], v: f64, near: f64, accel: f64) -> Vec<Corner> {
    let set = clip(set, |[u, _]| u - v - near);
    let set = clip(&set, |[u, _]| v - u - near);
    let set = clip(&set, |[_, a]| a - accel);
    simpler(clip(&set, |[_, a]| -a - accel))
}

/// The time at which the law is broken, if it is, by the steps of an axis from rest at 0 to rest at `end`, with
/// a jump, an acceleration and a jerk.
pub fn jerk_broken(steps: &Axis, size: f64, limits: [f64; 3], end: f64) -> Option<f64> {
    let [jump, accel, jerk] = limits;
    let half = jump / 2.0;
    // After a long rest u may be on its way from one side to the other.
    let mut set = vec![[-half, 0.0], [half, 0.0]];
    let short = (jump / jerk).sqrt() / 32.0;
    for _ in 0..512 {
        set = seen(&later(&set, short, jerk), 0.0, half, accel);
    }
    let mut now = 0.0;
    for Mean { time: t, wide, speed: v, off } in means(steps, size, accel, end) {
        set = later(&set, t - now, jerk);
        now = t;
        let rounded = 1e-9 * (1.0 + v.abs());
        set = seen(&set, v, half + jerk * wide * wide / 24.0 + off + rounded, accel);
        if set.is_empty() {
            return Some(t);
        }
    }
    None
}
