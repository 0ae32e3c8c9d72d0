//! Where a course is beyond what is allowed, and what to do about it.
//!
//! ```text
//!   v          ╱▔▔▔ top          The acceleration that turning leaves becomes less as it is faster. One rise
//!            ╱                   has the least of its way, two have each their own:
//!          ╱ ╱
//!        B ╱       one:  v₁/a₁ + a₁/J,   two:  vₙ/aₙ + aₙ/J + (v₁ − vₙ)/a₁ + a₁/J
//!       ╱╱
//! ```
//!
//! Two are faster where a node with no acceleration costs less than a lower one on the whole rise: with a
//! high jerk, on curves that are long. What a rise costs is its time beyond that of its way at the speed it leads to.

use std::ops::Range;

use crate::piece::{Moment, Piece};
use crate::ramp::Limits;
use crate::runs::{Ground, ROUNDED};

/// The part of its acceleration down to which a rise of two goes on with all of it.
const FIRST: f64 = 0.8;

/// What a course exceeds.
pub(crate) enum Beyond {
    /// The w of a node, or the course is to be divided there; the speed that it has there.
    Node(usize, f64),
    /// The acceleration over a cell, and the one to try next.
    Accel(usize, f64),
    /// The w within a cell; the highest speed to try next.
    Top(f64),
}

/// Speeding up, or braking.
#[derive(Clone, Copy, Default)]
struct Side {
    /// The largest part of its acceleration that there is nowhere beyond: the cell, and the acceleration of
    /// the course there.
    worst: Option<(f64, usize, f64)>,
    /// The node next to the end of it at which less than [`FIRST`] of it is there; the speed and its acceleration.
    split: Option<(usize, f64, f64)>,
}

impl Side {
    /// Over a cell, where a course is as steep as this, and may be as `slope`.
    fn pass(&mut self, cell: usize, steep: f64, slope: f64) {
        let part = slope / steep;
        if steep > 0.0 && part < self.worst.map_or(1.0 - ROUNDED, |(worst, ..)| worst) {
            self.worst = Some((part, cell, steep));
        }
    }

    /// What two rises gain over one, from this speed to the highest; above 0 only if they do.
    fn gain(&self, from: f64, high: f64, jerk: f64) -> Option<(f64, Beyond)> {
        let (part, _, steep) = self.worst?;
        let (node, v, first) = self.split?;
        let cost = |accel: f64, from: f64, to: f64| {
            let limits = Limits { accel, jerk };
            limits.time(to - from) - limits.way(from, to) / high
        };
        // None is there at a joint that binds.
        let last = part.max(ROUNDED) * steep;
        let gain = cost(last, from, high) - cost(FIRST * first, from, v) - cost(last, v, high);
        (gain > 0.0).then_some((gain, Beyond::Node(node, v)))
    }
}

impl<const N: usize> Ground<'_, N> {
    /// Where a course is furthest beyond what is allowed.
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
