//! Finds what a course exceeds, and what to try next.
//!
//! ```text
//!   v          ╱▔▔▔ top          At a higher speed turning leaves less acceleration. One rise has the least
//!            ╱                   acceleration of its way, each of two rises has its own:
//!          ╱ ╱
//!        B ╱       one:  v₁/a₁ + a₁/J,   two:  vₙ/aₙ + aₙ/J + (v₁ − vₙ)/a₁ + a₁/J
//!       ╱╱
//! ```
//!
//! Two rises are faster where a node without acceleration costs less than a lower acceleration over the whole
//! rise: on long curves, with a high jerk. The cost of a rise is its time beyond that of the same distance at
//! the highest speed of the course.

use std::ops::Range;

use crate::piece::{Moment, Piece};
use crate::ramp::Limits;
use crate::runs::{Ground, ROUNDED};

/// The first of two rises ends where less than this part of its acceleration is allowed.
const FIRST: f64 = 0.8;

/// What a course exceeds, and what to try next.
pub(crate) enum Beyond {
    /// The w of a node, or the node at which to divide the course; with the speed of the course there.
    Node(usize, f64),
    /// The acceleration within a cell, and the acceleration to try next.
    Accel(usize, f64),
    /// The w within a cell, by the top speed to try next.
    Top(f64),
}

/// One side of a course: speeding up, or braking.
#[derive(Clone, Copy, Default)]
struct Side {
    /// The smallest ratio of the allowed acceleration to that of the course, the cell, and the acceleration of
    /// the course there. `None` if the course exceeds none.
    worst: Option<(f64, usize, f64)>,
    /// Seen from the slow end of this side, the first node beyond which less than [`FIRST`] of the acceleration
    /// of the course is allowed; the speed there, and that acceleration.
    split: Option<(usize, f64, f64)>,
}

impl Side {
    /// Passes a cell in which the course has the acceleration `steep`, and `slope` is allowed.
    fn pass(&mut self, cell: usize, steep: f64, slope: f64) {
        let part = slope / steep;
        if steep > 0.0 && part < self.worst.map_or(1.0 - ROUNDED, |(worst, ..)| worst) {
            self.worst = Some((part, cell, steep));
        }
    }

    /// The time that two rises from this speed to the highest gain over one rise, in s, and where to divide.
    /// `None` if they gain nothing.
    fn gain(&self, from: f64, high: f64, jerk: f64) -> Option<(f64, Beyond)> {
        let (part, _, steep) = self.worst?;
        let (node, v, first) = self.split?;
        let cost = |accel: f64, from: f64, to: f64| {
            let limits = Limits { accel, jerk };
            limits.time(to - from) - limits.way(from, to) / high
        };
        // At a joint that binds the allowed acceleration may be 0.
        let last = part.max(ROUNDED) * steep;
        let gain = cost(last, from, high) - cost(FIRST * first, from, v) - cost(last, v, high);
        (gain > 0.0).then_some((gain, Beyond::Node(node, v)))
    }
}

impl<const N: usize> Ground<'_, N> {
    /// Returns what a course exceeds: the node with the largest excess, else the top speed, else the
    /// acceleration. `None` if the course keeps its limits.
    pub fn beyond(&self, cells: Range<usize>, pieces: &[Piece], top: f64) -> Option<Beyond> {
        let mut worst: Option<(f64, usize, f64)> = None;
        let [mut rise, mut fall] = [Side::default(); 2];
        let (mut peak, mut high) = (f64::INFINITY, 0.0f64);
        let mut n = 0;
        let mut before = pieces.first()?.from;
        for cell in cells.clone() {
            let end = self.cells.get(cell)?.end;
            let (mut most, mut up, mut down) = (before.v, before.a, -before.a);
            let mut pass = |to: Moment| {
                (most, up, down) = (most.max(to.v), up.max(to.a), down.max(-to.a));
            };
            while n + 1 < pieces.len() && pieces[n].to.s < end {
                pass(pieces[n].to);
                n += 1;
            }
            let piece = &pieces[n];
            let cap = self.caps.get(cell + 1).copied().unwrap_or(0.0);
            let here = if end >= piece.to.s { piece.to } else { piece.at(piece.time(end)) };
            let inner = cell + 1 < cells.end;
            if inner {
                let over = here.v * here.v / cap;
                if over > 1.0 + ROUNDED && worst.is_none_or(|known| over > known.0) {
                    worst = Some((over, cell + 1, here.v));
                }
            }
            pass(here);
            let limit = self.tops[cell];
            if most * most > limit * (1.0 + ROUNDED) {
                peak = peak.min(limit.sqrt().max(before.v.min(here.v)));
            }
            let (ground, w) = (&self.cells[cell], most * most);
            let (speed_up, brake) = (ground.speed_up(w), ground.brake(w));
            rise.pass(cell, up, speed_up);
            fall.pass(cell, down, brake);
            if speed_up < FIRST * up && rise.split.is_none() && cell > cells.start {
                rise.split = Some((cell, before.v, up));
            }
            if brake < FIRST * down && inner {
                fall.split = Some((cell + 1, here.v, down));
            }
            high = high.max(most);
            before = here;
        }
        if let Some((_, node, v)) = worst {
            return Some(Beyond::Node(node, v));
        }
        if peak < top {
            return Some(Beyond::Top(peak));
        }
        let jerk = self.limits(cells.start, cells.end).jerk;
        let gains = [(rise, pieces.first()?.from.v), (fall, before.v)];
        let gains = gains.iter().filter_map(|(side, end)| side.gain(*end, high, jerk));
        if let Some((_, divide)) = gains.max_by(|a, b| a.0.total_cmp(&b.0)) {
            return Some(divide);
        }
        let worst = [rise, fall].into_iter().filter_map(|side| side.worst);
        let (part, cell, steep) = worst.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(Beyond::Accel(cell, steep * part.clamp(0.5, 0.98)))
    }
}
