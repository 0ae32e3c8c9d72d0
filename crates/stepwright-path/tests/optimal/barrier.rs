//! The fastest speed with limited jerk, by an interior point. Beside the limits of each cell:
//!
//! ```text
//!   |w''| ≤ 2·jerk/√w            along the path: its third derivative in time
//!   a²    ≤ 2·jerk·v             or the speed was below 0 just before, or is just behind
//!   |Δκ|·w ≤ √(8·jump·jerk)      where the curvature changes at once: a ramp of the acceleration
//!                                beside a step of Δ is up to Δ²/8·jerk off in speed
//! ```
//!
//! The jerk of turning is not limited within an arc: there this may be faster than any axis. Newton's
//! method on the time less a logarithm of each distance to a limit. The curvature of the limits that
//! are not convex is left out, so each step is a descent, and each speed keeps the limits. What is
//! found is a local optimum. Compare Consolini et al., arXiv 2105.15095.

use stepwright_path::AxisPace;

use super::{Cell, Grid};

/// Of the time, by which it may be above the optimum.
const GAP: f64 = 1e-4;

struct Problem<'a, const N: usize> {
    grid: &'a Grid<N>,
    axes: &'a [AxisPace; N],
    /// w at each node at most, and the jerk along each cell.
    caps: Vec<f64>,
    jerk: Vec<f64>,
}

/// A symmetric matrix with two bands beside the diagonal, and a gradient.
struct Newton {
    bands: [Vec<f64>; 3],
    slope: Vec<f64>,
}

impl Newton {
    /// The solution of H·x = −gradient, but for the first node and the last.
    fn step(&self) -> Vec<f64> {
        let count = self.slope.len();
        let mut x = vec![0.0; count];
        // H = L·D·Lᵀ, with 1 on L's diagonal.
        let (mut d, mut l1, mut l2) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let far = |n: usize, by: usize| n > by;
        for n in 1..count - 1 {
            let two = if far(n, 2) { self.bands[2][n - 2] } else { 0.0 };
            let one = if far(n, 1) { self.bands[1][n - 1] } else { 0.0 };
            l2[n] = if far(n, 2) { two / d[n - 2] } else { 0.0 };
            let known = if far(n, 2) { l2[n] * d[n - 2] * l1[n - 1] } else { 0.0 };
            l1[n] = if far(n, 1) { (one - known) / d[n - 1] } else { 0.0 };
            d[n] = self.bands[0][n];
            if far(n, 1) {
                d[n] -= l1[n] * l1[n] * d[n - 1];
            }
            if far(n, 2) {
                d[n] -= l2[n] * l2[n] * d[n - 2];
            }
            // What is left of it by rounding.
            d[n] = d[n].max(self.bands[0][n] * 1e-13);
            x[n] = -self.slope[n];
            if far(n, 1) {
                x[n] -= l1[n] * x[n - 1];
            }
            if far(n, 2) {
                x[n] -= l2[n] * x[n - 2];
            }
        }
        for n in (1..count - 1).rev() {
            x[n] /= d[n];
            if n + 1 < count - 1 {
                x[n] -= l1[n + 1] * x[n + 1];
            }
            if n + 2 < count - 1 {
                x[n] -= l2[n + 2] * x[n + 2];
            }
        }
        x
    }

    fn curve(&mut self, n: usize, m: usize, by: f64) {
        self.bands[m - n][n] += by;
    }
}

impl<const N: usize> Problem<'_, N> {
    /// Each distance to a limit, with the first node that it depends on and its slopes.
    fn limits(&self, w: &[f64], mut each: impl FnMut(usize, [f64; 3], f64)) {
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
                let most = 2.0 * (2.0 * self.jerk[n]).sqrt() * length * middle.powf(0.25);
                let slope = most / middle / 8.0;
                each(n, [slope + 1.0, slope - 1.0, 0.0], most - (next - here));
                each(n, [slope - 1.0, slope + 1.0, 0.0], most + (next - here));
            }
        }
        for n in 1..last {
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

    /// The time less the logarithms; infinite beyond a limit.
    fn value(&self, w: &[f64], weight: f64) -> f64 {
        let mut sum = 0.0;
        let mut beyond = w.iter().any(|w| w.is_nan() || *w < 0.0);
        if !beyond {
            self.limits(w, |_, _, left| {
                beyond |= left.is_nan() || left <= 0.0;
                sum += left.ln();
            });
        }
        if beyond { f64::INFINITY } else { self.grid.time(w, true) - weight * sum }
    }

    fn newton(&self, w: &[f64], weight: f64) -> Newton {
        let count = w.len();
        let mut newton =
            Newton { bands: std::array::from_fn(|_| vec![0.0; count]), slope: vec![0.0; count] };
        for (n, cell) in self.grid.cells.iter().enumerate() {
            let part = if n == 0 || n + 2 == count { 3.0 } else { 2.0 } * cell.length;
            let v = [w[n].sqrt(), w[n + 1].sqrt()];
            let sum = v[0] + v[1];
            for m in [0, 1].into_iter().filter(|m| v[*m] > 0.0) {
                newton.slope[n + m] -= part / (sum * sum) / (2.0 * v[m]);
                let curve = 2.0 / sum.powi(3) / (4.0 * v[m].powi(2))
                    + 1.0 / sum.powi(2) / (4.0 * v[m].powi(3));
                newton.curve(n + m, n + m, part * curve);
            }
            if v[0] > 0.0 && v[1] > 0.0 {
                newton.curve(n, n + 1, part * 2.0 / sum.powi(3) / (4.0 * v[0] * v[1]));
            }
        }
        self.limits(w, |first, slopes, left| {
            let by = weight / left;
            for m in 0..3 {
                if slopes[m] == 0.0 {
                    continue;
                }
                newton.slope[first + m] -= by * slopes[m];
                for k in m..3 {
                    if slopes[k] != 0.0 {
                        newton.curve(first + m, first + k, by / left * slopes[m] * slopes[k]);
                    }
                }
            }
        });
        newton
    }
}

/// The time of the fastest speed.
pub fn fastest<const N: usize>(grid: &Grid<N>, axes: &[AxisPace; N]) -> f64 {
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
    for n in 1..last {
        let (before, after) = (&cells[n - 1].ends[1], &cells[n].ends[0]);
        for (axis, pace) in axes.iter().enumerate() {
            let corner = (after.t[axis] - before.t[axis]).abs() > 1e-6;
            let change = (after.k[axis] - before.k[axis]).abs();
            if !corner && change > 1e-9 {
                caps[n] = caps[n].min((8.0 * pace.jump * pace.jerk).sqrt() / change);
            }
        }
    }
    // From rest: w = (9·J/2)^⅔·s^(4/3).
    let from_rest = |jerk: f64, s: f64| (4.5 * jerk).powf(2.0 / 3.0) * s.powf(4.0 / 3.0);
    caps[1] = caps[1].min(from_rest(jerk[0], cells[0].length));
    caps[last - 1] = caps[last - 1].min(from_rest(jerk[last - 1], cells[last - 1].length));
    let problem = Problem { grid, axes, caps, jerk };
    // A slow speed within all limits.
    let length: f64 = cells.iter().map(|cell| cell.length).sum();
    let mut w = vec![0.0; last + 1];
    let mut s = 0.0;
    for (n, cell) in cells.iter().enumerate().take(last - 1) {
        s += cell.length;
        w[n + 1] = from_rest(1e3, s * (length - s) / length);
    }
    let mut tries = 0;
    while problem.value(&w, 0.0).is_infinite() {
        w.iter_mut().for_each(|w| *w *= 0.5);
        tries += 1;
        assert!(tries < 100, "no speed keeps the limits");
    }
    let mut limits = 0;
    problem.limits(&w, |_, _, _| limits += 1);
    let limits = f64::from(limits);
    let mut weight = grid.time(&w, true) / limits;
    loop {
        for _ in 0..60 {
            let newton = problem.newton(&w, weight);
            let step = newton.step();
            let descent: f64 =
                newton.slope.iter().zip(&step).map(|(slope, step)| slope * step).sum();
            let before = problem.value(&w, weight);
            let mut part = 1.0;
            let mut found = None;
            while part > 1e-10 {
                let next: Vec<f64> = w.iter().zip(&step).map(|(w, step)| w + part * step).collect();
                if problem.value(&next, weight) <= before + 1e-4 * part * descent {
                    found = Some(next);
                    break;
                }
                part /= 2.0;
            }
            let Some(next) = found else { break };
            w = next;
            if -descent < 1e-3 * weight * limits * 1e-2 {
                break;
            }
        }
        let time = grid.time(&w, true);
        if weight * limits < GAP * time {
            return time;
        }
        weight *= 0.3;
    }
}
