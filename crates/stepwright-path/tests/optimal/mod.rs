//! Offline optima of paths, on a fine grid along them. They share no code with the planner of a route.
//!
//! For each cell between two nodes, the direction t and the curvature κ of each axis are known at both ends.
//! With w = v² at the nodes and the acceleration a = Δw/2h along a cell:
//!
//! ```text
//!   |t·a + κ·w| ≤ accel                 each axis, at both ends of each cell
//!   w ≤ feed², |t|·v ≤ speed            over a cell
//!   |Δt|·v ≤ jump                       at a corner, and from one chord to the next
//!   |κ|·w ≤ accel                       where that is asked for
//! ```
//!
//! A planner that can hold its speed anywhere keeps the last limit; an axis that brakes at the same time may
//! turn faster. Chords of a curve turn evenly from the middle of one to the middle of the next.

pub mod bands;
pub mod barrier;
pub mod passes;
pub mod paths;

use std::f64::consts::FRAC_PI_2;

use stepwright_path::AxisPace;

/// One end of a cell: the direction of each axis, and its change per unit.
#[derive(Clone, Copy, Debug)]
pub struct End<const N: usize> {
    pub t: [f64; N],
    pub k: [f64; N],
}

/// The path from one node to the next.
#[derive(Clone, Copy, Debug)]
pub struct Cell<const N: usize> {
    pub length: f64,
    pub ends: [End<N>; 2],
}

/// A path: its cells, and the largest w at each node.
pub struct Grid<const N: usize> {
    pub cells: Vec<Cell<N>>,
    pub caps: Vec<f64>,
}

/// A line or an arc of the first two axes.
#[derive(Clone, Copy, Debug)]
pub enum Shape<const N: usize> {
    Line { t: [f64; N], length: f64 },
    Arc { radius: f64, from: f64, sweep: f64 },
}

/// A piece of a path. `chord` tells whether it continues the curve of the piece before.
#[derive(Clone, Copy, Debug)]
pub struct Piece<const N: usize> {
    pub shape: Shape<N>,
    pub feed: f64,
    pub chord: bool,
}

impl<const N: usize> Shape<N> {
    pub fn length(&self) -> f64 {
        match *self {
            Shape::Line { length, .. } => length,
            Shape::Arc { radius, sweep, .. } => radius * sweep.abs(),
        }
    }

    pub fn end(&self, s: f64) -> End<N> {
        match *self {
            Shape::Line { t, .. } => End { t, k: [0.0; N] },
            Shape::Arc { radius, from, sweep } => {
                let sign = sweep.signum();
                let angle = from + sign * s / radius;
                let (mut t, mut k) = ([0.0; N], [0.0; N]);
                for (axis, ahead) in [0.0, FRAC_PI_2].into_iter().enumerate() {
                    let (sin, cos) = (angle - ahead).sin_cos();
                    (t[axis], k[axis]) = (-sign * sin, -cos / radius);
                }
                End { t, k }
            }
        }
    }
}

/// The longest and the shortest cell, and the length of a cell as a part of its distance from a joint.
const LONGEST: f64 = 0.2;
const SHORTEST: f64 = 0.004;
const GRADE: f64 = 0.06;

/// Ends of cells from 0 to a length, finer towards both ends.
fn cuts(length: f64) -> Vec<f64> {
    let (mut half, mut s) = (vec![], 0.0);
    while s < length / 2.0 {
        s += (GRADE * s).clamp(SHORTEST, LONGEST);
        half.push(s);
    }
    // Scaled, so that the last one is in the middle.
    let part = half.last().map_or(1.0, |last| length / 2.0 / last);
    let back = half.iter().rev().skip(1).map(|s| length - s * part);
    half.iter().map(|s| s * part).chain(back).chain([length]).collect()
}

impl<const N: usize> Grid<N> {
    /// `level` limits the speed to that at which each axis could turn at a constant speed.
    pub fn new(path: &[Piece<N>], axes: &[AxisPace; N], level: bool) -> Grid<N> {
        let (mut cells, mut caps): (Vec<Cell<N>>, Vec<f64>) = (vec![], vec![0.0]);
        // Between a piece and the piece before: the turn, and the lengths before and behind over which it
        // turns.
        let turn = |n: usize| {
            let (before, after) = (n.checked_sub(1).map(|n| path[n])?, path.get(n)?);
            let lengths = [before.shape.length(), after.shape.length()];
            let zones = [0, 1].map(|n| (lengths[n] / 2.0).min(lengths[1 - n]));
            let from = before.shape.end(lengths[0]).t;
            let turn: [f64; N] =
                std::array::from_fn(|axis| after.shape.end(0.0).t[axis] - from[axis]);
            Some((from, turn, zones, after.chord))
        };
        for (n, piece) in path.iter().enumerate() {
            let length = piece.shape.length();
            let curve = |n| turn(n).filter(|(.., chord)| *chord);
            let [begin, end] = [curve(n), curve(n + 1)];
            let zones = [begin.map_or(0.0, |turn| turn.2[1]), end.map_or(0.0, |turn| turn.2[0])];
            let at = |s: f64, middle: f64| {
                let bent = |(from, turn, zones, _): ([f64; N], [f64; N], [f64; 2], bool),
                            s: f64| {
                    let all = zones[0] + zones[1];
                    let part = (zones[0] + s) / all;
                    let t = std::array::from_fn(|axis| from[axis] + turn[axis] * part);
                    End { t, k: turn.map(|turn| turn / all) }
                };
                match (begin, end) {
                    (Some(turn), _) if middle < zones[0] => bent(turn, s),
                    (_, Some(turn)) if middle > length - zones[1] => bent(turn, s - length),
                    _ => piece.shape.end(s),
                }
            };
            let sections = [zones[0], length - zones[0] - zones[1], zones[1]];
            let mut from = 0.0;
            for section in sections.into_iter().filter(|section| *section > 1e-9) {
                let begin = from;
                for to in cuts(section).into_iter().map(|cut| begin + cut) {
                    let middle = (from + to) / 2.0;
                    let ends = [at(from, middle), at(to, middle)];
                    cells.push(Cell { length: to - from, ends });
                    let mut cap = piece.feed * piece.feed;
                    for (axis, pace) in axes.iter().enumerate() {
                        let t = ends[0].t[axis].abs().max(ends[1].t[axis].abs());
                        cap = cap.min((pace.speed / t).powi(2));
                        if level {
                            let k = ends[0].k[axis].abs().max(ends[1].k[axis].abs());
                            cap = cap.min(pace.accel / k);
                        }
                    }
                    // The limit of a cell applies at both of its nodes.
                    if let Some(last) = caps.last_mut() {
                        *last = cap.min(*last);
                    }
                    caps.push(cap);
                    from = to;
                }
            }
            if let Some((_, turn, ..)) = turn(n + 1)
                && let Some(last) = caps.last_mut()
            {
                for (pace, turn) in axes.iter().zip(turn).filter(|(_, turn)| turn.abs() > 1e-9) {
                    *last = last.min((pace.jump / turn).powi(2));
                }
            }
        }
        if let Some(last) = caps.last_mut() {
            *last = 0.0;
        }
        Grid { cells, caps }
    }

    /// The time of a speed. If `smooth`, the jerk from and to rest is constant.
    pub fn time(&self, w: &[f64], smooth: bool) -> f64 {
        let cell = |(n, cell): (usize, &Cell<N>)| {
            let sum = w[n].sqrt() + w[n + 1].sqrt();
            let rest = smooth && (w[n] == 0.0 || w[n + 1] == 0.0);
            if rest { 3.0 * cell.length / sum } else { 2.0 * cell.length / sum }
        };
        self.cells.iter().enumerate().map(cell).sum()
    }
}
