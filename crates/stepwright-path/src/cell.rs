//! A stretch of a route over which the limits are the same, and the speed over it.
//!
//! Along the route, with w = v² and the direction t of an axis, the axis accelerates by
//!
//! ```text
//!   d(v·t)/dt = t·dv/dt + w·dt/ds        |t| ≤ tilt, |dt/ds| ≤ bend
//! ```
//!
//! which stays within its limit A where |dv/dt| ≤ (A − bend·w) / tilt: what turning takes of the
//! limit is not there for speeding up. Over a cell the acceleration is constant, w a straight
//! line over s, and the limit at the higher end holds for all of it:
//!
//! ```text
//!   w₁ ≤ (w₀ + 2·L·A/tilt) / (1 + 2·L·bend/tilt)                       one way
//!   w  ≤ (w₀ + w₁ + 2·L·A/tilt) / (2 + 2·L·bend/tilt)                  the peak in between
//! ```

use crate::piece::{Moment, Piece};
use crate::shape::Shape;

/// A part of a piece of a route.
#[derive(Clone, Debug)]
pub(crate) struct Cell<const N: usize> {
    pub shape: Shape<N>,
    pub begin: f64,
    pub end: f64,
    /// The direction at both ends.
    pub first: [f64; N],
    pub last: [f64; N],
    /// Of each axis: the acceleration along the route that its limit allows at rest, and by how
    /// much that falls in a unit of w.
    room: [(f64, f64); N],
    /// The ordered speed and what part of it is in force, the w that the axes can follow, and the w
    /// of both as it is now.
    pub feed: f64,
    scale: f64,
    /// It is of a rapid, which has a scale of its own.
    pub rapid: bool,
    pub most: f64,
    pub top: f64,
    /// The w at its beginning, at most; and how far it turns there on each side, if its joint is
    /// one of a curve.
    pub cap: f64,
    pub zone: f64,
}

/// Parts of the ordered speed: overrides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scales {
    pub feed: f64,
    pub rapid: f64,
}

/// The speed over a cell: from one to a level, along it, and on to the other; all as w, and the
/// ways of the three.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trip {
    w: [f64; 4],
    ways: [f64; 3],
}

impl<const N: usize> Cell<N> {
    /// Of a shape, between two places of it: `bend` and `tilt` of each axis beside those of the
    /// shape itself, which for a line come from its joints.
    pub fn new(
        shape: &Shape<N>,
        (begin, end): (f64, f64),
        (bend, tilt): ([f64; N], [f64; N]),
        accel: &[f64; N],
        speed: &[f64; N],
        feed: f64,
    ) -> Cell<N> {
        let (own, steep) = shape.bounds(begin, end);
        let mut most = f64::INFINITY;
        let room = std::array::from_fn(|n| {
            let (bend, tilt) = (own[n] + bend[n], steep[n].max(tilt[n]));
            most = most.min((speed[n] / tilt).powi(2)).min(FULL * accel[n] / bend);
            if tilt > 0.0 { (accel[n] / tilt, bend / tilt) } else { (f64::INFINITY, 0.0) }
        });
        let (first, last) = (shape.direction(begin), shape.direction(end));
        let top = most.min(feed * feed);
        let (shape, scale, cap, zone, rapid) = (*shape, 1.0, f64::INFINITY, 0.0, false);
        Cell { shape, begin, end, first, last, room, feed, scale, rapid, most, top, cap, zone }
    }

    /// A part of it, to whose beginning there is no joint.
    pub fn part(&self, begin: f64, end: f64) -> Cell<N> {
        let (first, last) = (self.shape.direction(begin), self.shape.direction(end));
        let last = if end < self.end { last } else { self.last };
        Cell { begin, end, first, last, cap: f64::INFINITY, zone: 0.0, ..self.clone() }
    }

    /// The w up to which the axes can turn, in whatever direction: that of a circle is the same all
    /// around.
    pub fn turning(&self) -> f64 {
        let parts = self.room.iter().map(|(accel, curb)| (curb / accel).powi(2));
        1.0 / parts.filter(|part| part.is_finite()).sum::<f64>().sqrt()
    }

    /// Whether it turns: what it does in a curve of chords, too.
    pub fn turns(&self) -> bool {
        self.room.iter().any(|(_, curb)| *curb > 0.0)
    }

    pub fn length(&self) -> f64 {
        self.end - self.begin
    }

    /// From now on this part of the ordered speed.
    pub fn scale(&mut self, scales: Scales) {
        self.scale = if self.rapid { scales.rapid } else { scales.feed };
        self.top = self.most.min((self.feed * self.scale).powi(2));
    }

    /// The ordered speed as it is now.
    pub fn ordered(&self) -> f64 {
        self.feed * self.scale
    }

    /// The w at the other end, at most, by speeding up from this w.
    pub fn rise(&self, w: f64) -> f64 {
        let way = 2.0 * self.length();
        self.least(|accel, curb| (w + way * accel) / (1.0 + way * curb))
    }

    /// The w at the other end by braking from this w; below 0 if it stands before.
    pub fn fall(&self, w: f64) -> f64 {
        w - 2.0 * self.length() * self.slope(w)
    }

    /// The acceleration that is there at this w.
    pub fn slope(&self, w: f64) -> f64 {
        self.least(|accel, curb| accel - curb * w).max(0.0)
    }

    fn least(&self, of: impl Fn(f64, f64) -> f64) -> f64 {
        self.room.iter().map(|(accel, curb)| of(*accel, *curb)).fold(f64::INFINITY, f64::min)
    }

    /// The speed from w to w, which the cell allows.
    pub fn trip(&self, from: f64, to: f64) -> Trip {
        let all = self.length();
        let (level, slope) = if from > self.top {
            (self.top.max(to).min(from), self.slope(from))
        } else {
            let sum = from + to;
            let peak = self.least(|a, curb| (sum + 2.0 * all * a) / (2.0 + 2.0 * all * curb));
            let level = peak.min(self.top).max(from).max(to);
            (level, self.slope(level))
        };
        let way = |w: f64| if w == level { 0.0 } else { ((w - level) / slope / 2.0).abs() };
        let begin = way(from).min(all);
        let end = way(to).min(all - begin);
        Trip { w: [from, level, level, to], ways: [begin, all - begin - end, end] }
    }

    /// The trip as pieces in time from a moment at the cell's beginning on.
    pub fn pieces(&self, trip: &Trip, t: f64) -> [Piece; 3] {
        let (mut t, mut s) = (t, self.begin);
        std::array::from_fn(|n| {
            let (v, to) = (trip.w[n].sqrt(), trip.w[n + 1].sqrt());
            let time = trip.time(n);
            let a = if time > 0.0 { (to - v) / time } else { 0.0 };
            let from = Moment { t, s, v, a };
            (t, s) = (t + time, if n == 2 { self.end } else { s + trip.ways[n] });
            Piece { from, to: Moment { t, s, v: to, a }, jerk: 0.0 }
        })
    }
}

/// Of the acceleration, for turning at a constant speed: with all of it nothing would be left to
/// brake by.
const FULL: f64 = 0.999;

impl Trip {
    fn time(&self, n: usize) -> f64 {
        let sum = self.w[n].sqrt() + self.w[n + 1].sqrt();
        if self.ways[n] > 0.0 { 2.0 * self.ways[n] / sum } else { 0.0 }
    }

    /// Seconds that it takes.
    pub fn duration(&self) -> f64 {
        (0..3).map(|n| self.time(n)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(length: f64, bend: f64, feed: f64) -> Cell<2> {
        let shape = Shape::line(0.0, [0.0; 2], [length * 0.6, length * 0.8]);
        let ends = (0.0, length);
        Cell::new(&shape, ends, ([bend; 2], [0.0; 2]), &[600.0, 1_000.0], &[1e3; 2], feed)
    }

    #[test]
    fn a_trip_by_hand() {
        // X allows 600/0.6 = 1000 along the line, Y 1000/0.8 = 1250.
        let cell = cell(10.0, 0.0, 100.0);
        assert_eq!((cell.slope(9e9), cell.rise(0.0)), (1_000.0, 20_000.0));
        // 100² over 5 up and 5 down: 0.1 s each.
        let trip = cell.trip(0.0, 0.0);
        assert!((trip.duration() - 0.2).abs() < 1e-12);
        // From 100 down to 0 it takes half of it: 5 at 100, then 0.1 s.
        assert!((cell.trip(10_000.0, 0.0).duration() - 0.15).abs() < 1e-12);
    }

    #[test]
    fn turning_takes_of_what_there_is() {
        // A tenth of a radian in a unit: X has 600 − 0.1·w, over 0.6.
        let cell = cell(0.1, 0.1, 70.0);
        assert!((cell.slope(1_000.0) - 500.0 / 0.6).abs() < 1e-9);
        let w = cell.rise(1_000.0);
        assert!((w - 1_000.0 - 2.0 * 0.1 * cell.slope(w)).abs() < 1e-9);
        // Both ends of a cell agree on how much it can fall.
        assert!((cell.fall(w) - 1_000.0).abs() < 1e-9);
    }
}
