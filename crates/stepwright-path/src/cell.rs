//! A stretch of a route over which the limits are the same, and the speed over it.
//!
//! Along the route, with w = v² and the direction t of an axis, the axis accelerates by
//!
//! ```text
//!   d(v·t)/dt = t·dv/dt + w·dt/ds        |t| ≤ tilt, |dt/ds| ≤ bend
//! ```
//!
//! which stays within its limit A where |dv/dt| ≤ (A − bend·w) / tilt: what turning takes of the
//! limit is not there for speeding up. Where both parts have the same sign all over a cell, that is
//! so of speeding up alone, and to brake by there is all of A; where they differ it is the other way
//! about. Over a cell the acceleration is constant, w a straight line over s, and the limit at the
//! higher end holds for all of it:
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
    room: [Room; N],
    /// The ordered speed and what part of it is in force, the w that the axes can follow, and the w
    /// of both as it is now.
    pub feed: f64,
    scale: f64,
    /// It is of a rapid, which has a scale of its own.
    pub rapid: bool,
    pub most: f64,
    pub top: f64,
    /// The w at its beginning, at most; and how it turns there along the route, if its joint is one of a
    /// curve.
    pub cap: f64,
    pub turn: Option<[f64; N]>,
}

/// What the limit of an axis allows along the route.
#[derive(Clone, Copy, Debug)]
struct Room {
    /// The acceleration at rest, and by how much that falls in a unit of w: of speeding up, and of
    /// braking.
    accel: f64,
    curbs: [f64; 2],
}

/// How a stretch turns, of each axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend<const N: usize> {
    /// The change of its direction in a unit, and its direction, at most.
    pub bend: [f64; N],
    pub tilt: [f64; N],
    /// The sign of their product where it is the same all over: above 0 where turning takes of what
    /// there is to speed up by, below where of what there is to brake by. 0 where of either.
    pub lean: [f64; N],
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
    /// Of a shape, between two places of it. Joints bend it beside what it does itself.
    pub fn new(
        shape: &Shape<N>,
        (begin, end): (f64, f64),
        joints: &[Bend<N>],
        accel: &[f64; N],
        speed: &[f64; N],
        feed: f64,
    ) -> Cell<N> {
        let (own, steep) = shape.bounds(begin, end);
        let (first, last) = (shape.direction(begin), shape.direction(end));
        let [from, to] = [begin, end].map(|s| shape.curvature(s));
        let mut most = f64::INFINITY;
        let room = std::array::from_fn(|n| {
            let turns = joints.iter().map(|joint| joint.bend[n]).fold(0.0, f64::max);
            let tilt = joints.iter().map(|joint| joint.tilt[n]).fold(steep[n], f64::max);
            let bend = own[n] + turns;
            most = most.min((speed[n] / tilt).powi(2)).min(FULL * accel[n] / bend);
            if tilt == 0.0 {
                return Room { accel: f64::INFINITY, curbs: [0.0; 2] };
            }
            // What turns it: the shape, and each joint.
            let itself = [first[n] * from[n], last[n] * to[n]];
            let itself = itself.into_iter().filter(|_| own[n] > 0.0);
            let bends = joints.iter().filter(|joint| joint.bend[n] > 0.0);
            let mut leans = itself.chain(bends.map(|joint| joint.lean[n]));
            let curb = bend / tilt;
            let curbs = match leans.next() {
                Some(lean) if lean > 0.0 && leans.all(|lean| lean > 0.0) => [curb, 0.0],
                Some(lean) if lean < 0.0 && leans.all(|lean| lean < 0.0) => [0.0, curb],
                _ => [curb; 2],
            };
            Room { accel: accel[n] / tilt, curbs }
        });
        let top = most.min(feed * feed);
        let (shape, scale, cap, turn, rapid) = (*shape, 1.0, f64::INFINITY, None, false);
        Cell { shape, begin, end, first, last, room, feed, scale, rapid, most, top, cap, turn }
    }

    /// A part of it, to whose beginning there is no joint.
    pub fn part(&self, begin: f64, end: f64) -> Cell<N> {
        let (first, last) = (self.shape.direction(begin), self.shape.direction(end));
        let last = if end < self.end { last } else { self.last };
        Cell { begin, end, first, last, cap: f64::INFINITY, turn: None, ..self.clone() }
    }

    /// The w up to which the axes can turn, in whatever direction: that of a circle is the same all
    /// around.
    pub fn turning(&self) -> f64 {
        let parts = self.room.iter().map(|room| (room.curb() / room.accel).powi(2));
        1.0 / parts.filter(|part| part.is_finite()).sum::<f64>().sqrt()
    }

    /// Whether it turns: what it does in a curve of chords, too.
    pub fn turns(&self) -> bool {
        self.room.iter().any(|room| room.curb() > 0.0)
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

    /// The w at its end, at most, by speeding up from this w.
    pub fn rise(&self, w: f64) -> f64 {
        self.higher(w, |room| room.curbs[0])
    }

    /// The w at its beginning, at most, from which it can brake to this w.
    pub fn back(&self, w: f64) -> f64 {
        self.higher(w, |room| room.curbs[1])
    }

    /// The w at the other end, at most, whichever way it turns.
    pub fn least_rise(&self, w: f64) -> f64 {
        self.higher(w, Room::curb)
    }

    fn higher(&self, w: f64, curb: impl Fn(&Room) -> f64) -> f64 {
        let way = 2.0 * self.length();
        self.least(|room| (w + way * room.accel) / (1.0 + way * curb(room)))
    }

    /// The w at its end by braking from this w; below 0 if it stands before.
    pub fn fall(&self, w: f64) -> f64 {
        w - 2.0 * self.length() * self.brake(w)
    }

    /// The acceleration that is there at this w to speed up by.
    pub fn speed_up(&self, w: f64) -> f64 {
        self.least(|room| room.accel - room.curbs[0] * w).max(0.0)
    }

    /// The acceleration that is there at this w to brake by.
    pub fn brake(&self, w: f64) -> f64 {
        self.least(|room| room.accel - room.curbs[1] * w).max(0.0)
    }

    /// The acceleration that is there at this w for both.
    pub fn slope(&self, w: f64) -> f64 {
        self.least(|room| room.accel - room.curb() * w).max(0.0)
    }

    /// The acceleration that is there at this w if that of turning is square to it, as on a circle.
    pub fn tangent(&self, w: f64) -> f64 {
        self.least(|room| (room.accel.powi(2) - (room.curb() * w).powi(2)).max(0.0).sqrt())
    }

    fn least(&self, of: impl Fn(&Room) -> f64) -> f64 {
        self.room.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// The speed from w to w, which the cell allows.
    pub fn trip(&self, from: f64, to: f64) -> Trip {
        let all = self.length();
        let level = if from > self.top {
            self.top.max(to).min(from)
        } else {
            // With the less of both: with each by itself it would be a little higher.
            let sum = from + to;
            let way = 2.0 * all;
            let peak = self.least(|room| (sum + way * room.accel) / (2.0 + way * room.curb()));
            peak.min(self.top).max(from).max(to)
        };
        let brake = self.brake(from.max(level));
        let first = if from > level { brake } else { self.speed_up(level) };
        let way = |w: f64, slope: f64| {
            if w == level { 0.0 } else { (w - level).abs() / slope / 2.0 }
        };
        let begin = way(from, first).min(all);
        let end = way(to, brake).min(all - begin);
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

impl Room {
    /// Whichever way it turns.
    fn curb(&self) -> f64 {
        self.curbs[0].max(self.curbs[1])
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
        let joint = Bend { bend: [bend; 2], tilt: [0.0; 2], lean: [1.0; 2] };
        Cell::new(&shape, (0.0, length), &[joint], &[600.0, 1_000.0], &[1e3; 2], feed)
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
        // As on a circle: 600² − 100² = 591.6².
        assert!((cell.tangent(1_000.0) - 350_000f64.sqrt() / 0.6).abs() < 1e-9);
        assert_eq!(cell.tangent(7_000.0), 0.0);
        // To brake by there is all of it, and both ends agree on how much it can fall.
        assert!((cell.brake(w) - 1_000.0).abs() < 1e-9);
        let back = cell.back(1_000.0);
        assert!((back - 1_200.0).abs() < 1e-9 && (cell.fall(back) - 1_000.0).abs() < 1e-9);
    }
}
