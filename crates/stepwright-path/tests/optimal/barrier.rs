//! The fastest speed with limited jerk, by an interior-point method. In addition to the limits of each cell,
//! along the path:
//!
//! ```text
//!   |w''| ≤ 2·jerk/√w            its third derivative in time, but at corners
//!   a²    ≤ 2·jerk·v             or the speed was below 0 just before, or is just behind; not from
//!                                one corner to the next
//! ```
//!
//! and for each axis the law of jerk itself, with its speed t·v, and a speed u at each node as another
//! variable:
//!
//! ```text
//!   |t·v − u| ≤ jump/2           at both sides of a corner
//!   |u'| ≤ accel, |u''| ≤ jerk   in time: turning, and a jump of the acceleration at a corner, too
//! ```
//!
//! u may begin and end with any acceleration. Without that law there are no corners, the jerk of turning is not
//! limited, and |Δκ|·w ≤ √(8·jump·jerk) where the curvature changes at once: a ramp of the acceleration
//! deviates from a step of Δ by up to Δ²/8·jerk in speed.
//!
//! Newton's method minimises the time less a logarithm of each distance to a limit. The curvature of limits
//! that are not convex is left out, so each step is a descent, and each speed keeps the limits. The result is a
//! local optimum. Compare Consolini et al., arXiv 2105.15095.

use stepwright_path::AxisPace;

use super::bands::Bands;
use super::{Cell, Grid};

/// The part of the time by which the result may be above the optimum.
const GAP: f64 = 5e-4;

/// The factor from one weight to the next, and the most steps with each; one path took 1,000. With smaller
/// factors, and with 200 steps, some paths stopped before their optimum, up to 2.8 % slower.
const NEXT: f64 = 0.5;
const STEPS: usize = 2_000;

/// A descent of less than this part of the logarithms' share counts as none. With a larger part, the search
/// stops at slower speeds.
const NEAR: f64 = 1e-5;

/// The smallest addition to the diagonal of Newton's matrix, as a part of the diagonal.
const DAMP: f64 = 1e-10;

/// The most variables of a node: w, and u of each axis.
const MOST: usize = 4;

/// The derivatives of a distance by the variables of three nodes.
type Slopes = [[f64; MOST]; 3];

struct Problem<'a, const N: usize> {
    grid: &'a Grid<N>,
    axes: &'a [AxisPace; N],
    /// Whether each axis has the law of jerk.
    lawful: bool,
    /// The largest w at each node, and the jerk along each cell.
    caps: Vec<f64>,
    jerk: Vec<f64>,
    /// The nodes that are corners, and the acceleration along each cell that corners allow.
    corners: Vec<bool>,
    kinks: Vec<f64>,
}

/// w, and u of each axis, at each node.
#[derive(Clone)]
struct Speed<const N: usize> {
    w: Vec<f64>,
    u: Vec<[f64; N]>,
}

impl<const N: usize> Speed<N> {
    /// The speed after a part of a step, which has `each` variables per node.
    fn moved(&self, step: &[f64], part: f64, each: usize) -> Speed<N> {
        let mut next = self.clone();
        for (n, step) in step.chunks(each).enumerate() {
            next.w[n] += part * step[0];
            for (u, step) in next.u[n].iter_mut().zip(&step[1..]) {
                *u += part * step;
            }
        }
        next
    }

    /// The speed at a node, and its derivative by w.
    fn at(&self, n: usize) -> [f64; 2] {
        let v = self.w[n].sqrt();
        [v, if v > 0.0 { 0.5 / v } else { 0.0 }]
    }
}

/// The time over a cell and u' in it, and their derivatives by w and u of both nodes.
struct Rate {
    time: f64,
    rate: f64,
    times: [f64; 2],
    by: [[f64; 2]; 2],
}

impl Rate {
    /// From the speed of each node, its derivative by w, and u.
    fn new(length: f64, nodes: [([f64; 2], f64); 2]) -> Rate {
        let [([v, dv], u), ([v1, dv1], u1)] = nodes;
        let time = 2.0 * length / (v + v1);
        let rate = (u1 - u) / time;
        let times = [dv, dv1].map(|dv| -time / (v + v1) * dv);
        let by = [[-rate / time * times[0], -1.0 / time], [-rate / time * times[1], 1.0 / time]];
        Rate { time, rate, times, by }
    }
}

fn along(parts: [f64; 3]) -> Slopes {
    parts.map(|part| std::array::from_fn(|k| if k == 0 { part } else { 0.0 }))
}

fn minus(slopes: &Slopes) -> Slopes {
    slopes.map(|node| node.map(|part| -part))
}

impl<const N: usize> Problem<'_, N> {
    /// The number of variables of each node.
    fn each(&self) -> usize {
        if self.lawful { N + 1 } else { 1 }
    }

    /// Calls `each` with each distance to a limit, the first node on which it depends, and its derivatives.
    fn limits(&self, speed: &Speed<N>, mut each: impl FnMut(usize, &Slopes, f64)) {
        self.limits_along(&speed.w, |n, parts, left| each(n, &along(parts), left));
        if self.lawful {
            self.limits_of_axes(speed, each);
        }
    }

    fn limits_along(&self, w: &[f64], mut each: impl FnMut(usize, [f64; 3], f64)) {
        let cells = &self.grid.cells;
        let last = cells.len();
        for (n, (w, cap)) in w.iter().zip(&self.caps).enumerate().take(last).skip(1) {
            each(n, [1.0, 0.0, 0.0], *w);
            each(n, [-1.0, 0.0, 0.0], cap - w);
        }
        for (n, Cell { length, ends }) in cells.iter().enumerate() {
            let way = 2.0 * length;
            let (here, next) = (w[n], w[n + 1]);
            for (m, end) in ends.iter().enumerate() {
                for (axis, pace) in self.axes.iter().enumerate() {
                    let (mut a, mut b) = (-end.t[axis] / way, end.t[axis] / way);
                    *(if m == 0 { &mut a } else { &mut b }) += end.k[axis];
                    let accel = a * here + b * next;
                    each(n, [-a, -b, 0.0], pace.accel - accel);
                    each(n, [a, b, 0.0], pace.accel + accel);
                }
            }
            if n > 0 && n + 1 < last {
                let middle = (here + next) / 2.0;
                let part = 2.0 * self.jerk[n] * middle.sqrt();
                let most = way * (part + self.kinks[n].powi(2)).sqrt();
                let slope = way * way * part / middle / most / 8.0;
                each(n, [slope + 1.0, slope - 1.0, 0.0], most - (next - here));
                each(n, [slope - 1.0, slope + 1.0, 0.0], most + (next - here));
            }
        }
        for n in (1..last).filter(|n| !self.corners[*n]) {
            let [before, after] = [cells[n - 1].length, cells[n].length];
            let mean = (before + after) / 2.0;
            let (left, right) = (1.0 / (before * mean), 1.0 / (after * mean));
            let bend = left * w[n - 1] - (left + right) * w[n] + right * w[n + 1];
            let middle = (w[n - 1] + 2.0 * w[n] + w[n + 1]) / 4.0;
            let most = 2.0 * self.jerk[n - 1].max(self.jerk[n]) / middle.sqrt();
            let slope = -most / middle / 2.0;
            let parts = [slope / 4.0, slope / 2.0, slope / 4.0];
            let bends = [left, -(left + right), right];
            each(n - 1, std::array::from_fn(|m| parts[m] - bends[m]), most - bend);
            each(n - 1, std::array::from_fn(|m| parts[m] + bends[m]), most + bend);
        }
    }

    fn limits_of_axes(&self, speed: &Speed<N>, mut each: impl FnMut(usize, &Slopes, f64)) {
        for (axis, pace) in self.axes.iter().enumerate() {
            let k = axis + 1;
            let mut before: Option<Rate> = None;
            for (n, Cell { length, ends }) in self.grid.cells.iter().enumerate() {
                let nodes = [n, n + 1].map(|n| (speed.at(n), speed.u[n][axis]));
                for (m, ([v, dv], u)) in nodes.into_iter().enumerate() {
                    let mut slopes = [[0.0; MOST]; 3];
                    (slopes[m][0], slopes[m][k]) = (ends[m].t[axis] * dv, -1.0);
                    let off = ends[m].t[axis] * v - u;
                    each(n, &minus(&slopes), pace.jump / 2.0 - off);
                    each(n, &slopes, pace.jump / 2.0 + off);
                }
                let here = Rate::new(*length, nodes);
                let mut slopes = [[0.0; MOST]; 3];
                for m in [0, 1] {
                    [slopes[m][0], slopes[m][k]] = here.by[m];
                }
                each(n, &minus(&slopes), pace.accel - here.rate);
                each(n, &slopes, pace.accel + here.rate);
                if let Some(before) = before {
                    let half = pace.jerk / 2.0;
                    let (mut most, mut change) = ([[0.0; MOST]; 3], [[0.0; MOST]; 3]);
                    for m in [0, 1] {
                        most[m][0] += half * before.times[m];
                        most[m + 1][0] += half * here.times[m];
                        for (j, place) in [0, k].into_iter().enumerate() {
                            change[m][place] -= before.by[m][j];
                            change[m + 1][place] += here.by[m][j];
                        }
                    }
                    let sum = |sign: f64| -> Slopes {
                        let part = |m: usize, j: usize| most[m][j] + sign * change[m][j];
                        std::array::from_fn(|m| std::array::from_fn(|j| part(m, j)))
                    };
                    let left = half * (before.time + here.time);
                    let rises = here.rate - before.rate;
                    each(n - 1, &sum(-1.0), left - rises);
                    each(n - 1, &sum(1.0), left + rises);
                }
                before = Some(here);
            }
        }
    }

    /// The time less the logarithms; infinite if a limit is exceeded.
    fn value(&self, speed: &Speed<N>, weight: f64) -> f64 {
        let mut sum = 0.0;
        let mut beyond = speed.w.iter().any(|w| w.is_nan() || *w < 0.0);
        if !beyond {
            self.limits(speed, |_, _, left| {
                beyond |= left.is_nan() || left <= 0.0;
                sum += left.ln();
            });
        }
        if beyond { f64::INFINITY } else { self.grid.time(&speed.w, true) - weight * sum }
    }

    fn newton(&self, speed: &Speed<N>, weight: f64) -> Bands {
        let (w, count, each) = (&speed.w, speed.w.len(), self.each());
        let mut newton = Bands::new(count * each, 3 * each);
        // The path is at rest at both ends.
        let free = |n: usize, k: usize| k > 0 || (n > 0 && n + 1 < count);
        for (n, cell) in self.grid.cells.iter().enumerate() {
            let part = if n == 0 || n + 2 == count { 3.0 } else { 2.0 } * cell.length;
            let v = [w[n].sqrt(), w[n + 1].sqrt()];
            let sum = v[0] + v[1];
            for m in [0, 1].into_iter().filter(|m| v[*m] > 0.0) {
                let row = (n + m) * each;
                newton.slope[row] -= part / (sum * sum) / (2.0 * v[m]);
                let curve = 2.0 / sum.powi(3) / (4.0 * v[m].powi(2))
                    + 1.0 / sum.powi(2) / (4.0 * v[m].powi(3));
                newton.add(row, row, part * curve);
            }
            if v[0] > 0.0 && v[1] > 0.0 {
                let curve = part * 2.0 / sum.powi(3) / (4.0 * v[0] * v[1]);
                newton.add(n * each, (n + 1) * each, curve);
            }
        }
        self.limits(speed, |first, slopes, left| {
            let by = weight / left;
            let mut terms = [(0, 0.0); 3 * MOST];
            let mut some = 0;
            for (m, node) in slopes.iter().enumerate() {
                for (k, slope) in node.iter().enumerate().take(each) {
                    if *slope != 0.0 && free(first + m, k) {
                        terms[some] = ((first + m) * each + k, *slope);
                        some += 1;
                    }
                }
            }
            for (place, (row, slope)) in terms[..some].iter().enumerate() {
                newton.slope[*row] -= by * slope;
                for (column, other) in &terms[place..some] {
                    newton.add(*row, *column, by / left * slope * other);
                }
            }
        });
        newton
    }
}

/// The time of the fastest speed: with the law of each axis, or without it and smoothly over corners.
pub fn fastest<const N: usize>(grid: &Grid<N>, axes: &[AxisPace; N], lawful: bool) -> f64 {
    let cells = &grid.cells;
    let last = cells.len();
    let along = |cell: &Cell<N>| {
        let each = axes.iter().enumerate().map(|(axis, pace)| {
            pace.jerk / cell.ends[0].t[axis].abs().max(cell.ends[1].t[axis].abs())
        });
        each.fold(f64::INFINITY, f64::min)
    };
    let jerk: Vec<f64> = cells.iter().map(along).collect();
    let mut caps = grid.caps.clone();
    let corner = |n: usize| {
        let turns = |axis: usize| cells[n].ends[0].t[axis] - cells[n - 1].ends[1].t[axis];
        lawful && n > 0 && n < last && (0..N).any(|axis| turns(axis).abs() > 1e-6)
    };
    for n in (1..last).filter(|_| !lawful) {
        let (before, after) = (&cells[n - 1].ends[1], &cells[n].ends[0]);
        for (axis, pace) in axes.iter().enumerate() {
            let corner = (after.t[axis] - before.t[axis]).abs() > 1e-6;
            let change = (after.k[axis] - before.k[axis]).abs();
            if !corner && change > 1e-9 {
                caps[n] = caps[n].min((8.0 * pace.jump * pace.jerk).sqrt() / change);
            }
        }
    }
    let corners: Vec<bool> = (0..=last).map(corner).collect();
    let mut kinks = vec![0.0; last];
    let ends: Vec<usize> = (0..=last).filter(|n| *n == 0 || *n == last || corners[*n]).collect();
    for pair in ends.windows(2).filter(|pair| corners[pair[0]] || corners[pair[1]]) {
        let accel = |pace: &AxisPace| pace.accel * (N as f64).sqrt();
        kinks[pair[0]..pair[1]].fill(axes.iter().map(accel).fold(0.0, f64::max));
    }
    // From rest: w = (9·J/2)^⅔·s^(4/3).
    let from_rest = |jerk: f64, s: f64| (4.5 * jerk).powf(2.0 / 3.0) * s.powf(4.0 / 3.0);
    caps[1] = caps[1].min(from_rest(jerk[0], cells[0].length));
    caps[last - 1] = caps[last - 1].min(from_rest(jerk[last - 1], cells[last - 1].length));
    let problem = Problem { grid, axes, lawful, caps, jerk, corners, kinks };
    // A slow speed within all limits.
    let length: f64 = cells.iter().map(|cell| cell.length).sum();
    let mut speed = Speed { w: vec![0.0; last + 1], u: vec![[0.0; N]; last + 1] };
    let mut s = 0.0;
    for (n, cell) in cells.iter().enumerate().take(last - 1) {
        s += cell.length;
        speed.w[n + 1] = from_rest(1e3, s * (length - s) / length);
    }
    let mut tries = 0;
    while problem.value(&speed, 0.0).is_infinite() {
        speed.w.iter_mut().for_each(|w| *w *= 0.5);
        tries += 1;
        assert!(tries < 100, "no speed keeps the limits");
    }
    let mut limits = 0;
    problem.limits(&speed, |_, _, _| limits += 1);
    let limits = f64::from(limits);
    let mut weight = grid.time(&speed.w, true) / limits;
    // The addition to the diagonal, as a part of it: more where a step ends at a limit.
    let mut damp = DAMP;
    loop {
        for _ in 0..STEPS {
            let mut newton = problem.newton(&speed, weight);
            let step = newton.step(damp);
            let descent: f64 =
                newton.slope.iter().zip(&step).map(|(slope, step)| slope * step).sum();
            let before = problem.value(&speed, weight);
            let mut part = 1.0;
            let mut found = None;
            while part > 1e-6 && descent < 0.0 {
                let next = speed.moved(&step, part, problem.each());
                if problem.value(&next, weight) <= before + 1e-4 * part * descent {
                    found = Some(next);
                    break;
                }
                part /= 2.0;
            }
            damp = if part < 0.2 { damp * 10.0 } else { DAMP.max(damp / 10.0) };
            let Some(next) = found else {
                if damp > 1.0 {
                    break;
                }
                continue;
            };
            speed = next;
            if -descent < NEAR * weight * limits {
                break;
            }
        }
        let time = grid.time(&speed.w, true);
        if weight * limits < GAP * time {
            return time;
        }
        weight *= NEXT;
    }
}
