//! The fastest course from one node that binds to the next.
//!
//! ```text
//!   v         ╱▔▔▔╲
//!           ╱       ╲            up to its highest speed with the least limits of the cells
//!         ╱          ╲           that it rises over, down from it with those of the cells
//!       B             B          that it falls over
//!       ┆ up ┆    ┆ down ┆
//! ```
//!
//! Where the route turns, or its axes are unequal, the limits along it change from cell to cell. The cells of
//! each side are found in rounds: first with the smallest limits of all cells, then with the limits of the
//! cells that each side led over. Cells that a side leads over besides are added, until there are none.

use std::ops::Range;

use crate::course;
use crate::kink::Kink;
use crate::piece::{Moment, Piece};
use crate::ramp::{Limits, Sides};
use crate::runs::Ground;

/// A node that binds: without acceleration, except at a corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bind {
    /// The number of cells before it; for the beginning of a course, the number before the cell that it is in.
    pub node: usize,
    pub s: f64,
    pub v: f64,
}

/// The part of a route from one node that binds to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub from: Bind,
    pub to: Bind,
    /// The moment at its beginning, if the motion there has an acceleration already.
    pub begin: Option<Moment>,
    /// The accelerations that are allowed at both ends.
    pub kinks: Kink,
}

/// The most rounds in which the cells of both sides are searched.
const ROUNDS: usize = 4;

impl Span {
    /// These limits, with at least the acceleration at the beginning.
    pub fn with(&self, limits: Limits) -> Limits {
        self.begin.map_or(limits, |begin| limits.with(begin.a))
    }

    /// The course under these limits and a top speed.
    pub fn course(&self, sides: &Sides, top: f64) -> Vec<Piece> {
        let Span { from, to, begin, kinks } = *self;
        let corner = Moment { t: 0.0, s: from.s, v: from.v, a: kinks[0].min(sides.up.accel) };
        let first = begin.map_or(corner, |begin| Moment { t: 0.0, ..begin });
        let last = Moment { t: 0.0, s: to.s, v: to.v, a: -kinks[1].min(sides.down.accel) };
        for part in [1.0, 0.7, 0.4, 0.0] {
            let a = if begin.is_some() { first.a } else { part * first.a };
            let end = Moment { a: part * last.a, ..last };
            if a >= 0.0
                && let Some(pieces) = sides.over(Moment { a, ..first }, end, top)
            {
                return pieces;
            }
        }
        divided(course::lead(first, (to.s, to.v), top, &sides.least().pace()))
    }
}

impl<const N: usize> Ground<'_, N> {
    /// The cells from one node to the other.
    pub fn cells(&self, span: &Span) -> Range<usize> {
        let from = span.from.node;
        from..span.to.node.max(from + 1).min(self.cells.len())
    }

    /// The course with the limits of the cells that each side leads over.
    pub fn fastest(&self, span: &Span, top: f64) -> Vec<Piece> {
        let cells = self.cells(span);
        let limits = |from: usize, to: usize| span.with(self.limits(from, to));
        let least = Sides::both(limits(cells.start, cells.end));
        let all = span.course(&least, top);
        let (mut rise, mut fall) = self.sides(&all, &cells);
        for _ in 0..ROUNDS {
            let sides = Sides { up: limits(cells.start, rise), down: limits(fall, cells.end) };
            if sides == least {
                break;
            }
            let pieces = span.course(&sides, top);
            let (behind, first) = self.sides(&pieces, &cells);
            if behind <= rise && first >= fall {
                return pieces;
            }
            (rise, fall) = (behind.max(rise), first.min(fall));
        }
        all
    }

    /// The cell behind those over which a course rises, and the first cell over which it falls.
    fn sides(&self, pieces: &[Piece], cells: &Range<usize>) -> (usize, usize) {
        let up = pieces.iter().rfind(|piece| piece.from.a > 0.0 || piece.to.a > 0.0);
        let down = pieces.iter().find(|piece| piece.from.a < 0.0 || piece.to.a < 0.0);
        let last = |s: f64| self.cells.partition_point(|cell| cell.end < s);
        let first = |s: f64| self.cells.partition_point(|cell| cell.end <= s);
        let rise = up.map_or(cells.start, |piece| last(piece.to.s) + 1);
        let fall = down.map_or(cells.end, |piece| first(piece.from.s));
        // `clamp` would panic if there is no cell.
        let rise = rise.max(cells.start + 1).min(cells.end);
        (rise, fall.max(cells.start).min(cells.end.saturating_sub(1)))
    }
}

/// The same pieces, divided where the speed is highest or lowest.
pub(crate) fn divided(pieces: Vec<Piece>) -> Vec<Piece> {
    let mut divided = Vec::with_capacity(pieces.len() + 2);
    for piece in pieces {
        let Piece { from, to, jerk } = piece;
        if from.a * to.a < 0.0 {
            let turn = from.after(jerk, -from.a / jerk);
            if turn.t > from.t && turn.t < to.t {
                let turn = Moment { a: 0.0, ..turn };
                divided.push(Piece { from, to: turn, jerk });
                divided.push(Piece { from: turn, to, jerk });
                continue;
            }
        }
        divided.push(piece);
    }
    divided
}
