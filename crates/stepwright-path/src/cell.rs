//! A cell: a part of a route with constant limits, and the speed over it.
//!
//! Along the route, with w = v² and the component t of the direction for an axis, the acceleration of the axis
//! is
//!
//! ```text
//!   d(v·t)/dt = t·dv/dt + w·dt/ds        |t| ≤ tilt, |dt/ds| ≤ bend
//! ```
//!
//! It stays within the limit A of the axis if |dv/dt| ≤ (A − bend·w) / tilt: the part of the limit that turning
//! uses is not available for speeding up. If t and dt/ds have the same sign in the whole cell, this applies to
//! speeding up only, and all of A is available for braking. If their signs differ, it applies to braking only.
//! Within a cell the acceleration is constant, w is linear in s, and the limit at the faster end holds for the
//! whole cell:
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
    /// The ordered speed and its override. `most` is the largest w that the axes can follow, `top` the largest
    /// w by both.
    pub feed: f64,
    scale: f64,
    /// Whether the cell is part of a rapid, which has an override of its own.
    pub rapid: bool,
    pub most: f64,
    pub top: f64,
    /// The largest w at its beginning; and how the route turns there, if the joint is one of a curve.
    pub cap: f64,
    pub turn: Option<[f64; N]>,
}

/// The acceleration along the route that the limit of an axis allows.
#[derive(Clone, Copy, Debug)]
struct Room {
    /// The acceleration at rest, and its decrease per unit of w: for speeding up, and for braking.
    accel: f64,
    curbs: [f64; 2],
}

/// How a part of a route turns, for each axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bend<const N: usize> {
    /// The largest change of the direction per unit of the route, and the largest component of the direction.
    pub bend: [f64; N],
    pub tilt: [f64; N],
    /// The sign of direction times change, if it is the same everywhere. Above 0, turning uses a part of the
    /// acceleration for speeding up; below 0, of that for braking; at 0, of either.
    pub lean: [f64; N],
}

/// The overrides: factors of the ordered speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scales {
    pub feed: f64,
    pub rapid: f64,
}

/// The speed over a cell: a ramp to a constant speed, that speed, and a ramp to the speed at the end. The four
/// speeds as w, and the lengths of the three parts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Trip {
    w: [f64; 4],
    ways: [f64; 3],
}

impl<const N: usize> Cell<N> {
    /// A cell of a shape, between two places. Joints add their turning to that of the shape.
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
            // The signs of all turning: by the shape, and by each joint.
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

    /// A part of the cell, without a joint at its beginning.
    pub fn part(&self, begin: f64, end: f64) -> Cell<N> {
        let (first, last) = (self.shape.direction(begin), self.shape.direction(end));
        let last = if end < self.end { last } else { self.last };
        Cell { begin, end, first, last, cap: f64::INFINITY, turn: None, ..self.clone() }
    }

    /// The largest w at which the axes can turn, whatever the direction. On a circle it is the same all around.
    pub fn turning(&self) -> f64 {
        let parts = self.room.iter().map(|room| (room.curb() / room.accel).powi(2));
        1.0 / parts.filter(|part| part.is_finite()).sum::<f64>().sqrt()
    }

    /// Whether the cell turns, by itself or in a curve of chords.
    pub fn turns(&self) -> bool {
        self.room.iter().any(|room| room.curb() > 0.0)
    }

    pub fn length(&self) -> f64 {
        self.end - self.begin
    }

    /// Sets the overrides.
    pub fn scale(&mut self, scales: Scales) {
        self.scale = if self.rapid { scales.rapid } else { scales.feed };
        self.top = self.most.min((self.feed * self.scale).powi(2));
    }

    /// The ordered speed, override included.
    pub fn ordered(&self) -> f64 {
        self.feed * self.scale
    }

    /// The largest w at the end, by speeding up from this w at the beginning.
    pub fn rise(&self, w: f64) -> f64 {
        self.higher(w, |room| room.curbs[0])
    }

    /// The largest w at the beginning from which braking leads to this w at the end.
    pub fn back(&self, w: f64) -> f64 {
        self.higher(w, |room| room.curbs[1])
    }

    /// The smaller of [`rise`](Cell::rise) and [`back`](Cell::back).
    pub fn least_rise(&self, w: f64) -> f64 {
        self.higher(w, Room::curb)
    }

    fn higher(&self, w: f64, curb: impl Fn(&Room) -> f64) -> f64 {
        let way = 2.0 * self.length();
        self.least(|room| (w + way * room.accel) / (1.0 + way * curb(room)))
    }

    /// The w at the end, by braking from this w at the beginning; below 0 if the stop ends within the cell.
    pub fn fall(&self, w: f64) -> f64 {
        w - 2.0 * self.length() * self.brake(w)
    }

    /// The acceleration available for speeding up at this w.
    pub fn speed_up(&self, w: f64) -> f64 {
        self.least(|room| room.accel - room.curbs[0] * w).max(0.0)
    }

    /// The acceleration available for braking at this w.
    pub fn brake(&self, w: f64) -> f64 {
        self.least(|room| room.accel - room.curbs[1] * w).max(0.0)
    }

    /// The acceleration available for both at this w.
    pub fn slope(&self, w: f64) -> f64 {
        self.least(|room| room.accel - room.curb() * w).max(0.0)
    }

    /// The acceleration available at this w if that of turning is perpendicular to it, as on a circle.
    pub fn tangent(&self, w: f64) -> f64 {
        self.least(|room| (room.accel.powi(2) - (room.curb() * w).powi(2)).max(0.0).sqrt())
    }

    fn least(&self, of: impl Fn(&Room) -> f64) -> f64 {
        self.room.iter().map(of).fold(f64::INFINITY, f64::min)
    }

    /// The speed over the cell from one w to another, both of which the cell allows.
    pub fn trip(&self, from: f64, to: f64) -> Trip {
        let all = self.length();
        let level = if from > self.top {
            self.top.max(to).min(from)
        } else {
            // With the smaller acceleration of both. With each ramp's own, the peak would be a little higher.
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

    /// The trip as pieces in time, from the time `t` at the beginning of the cell.
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
    /// The larger decrease of both.
    fn curb(&self) -> f64 {
        self.curbs[0].max(self.curbs[1])
    }
}

/// The part of the acceleration for turning at a constant speed. With all of it, nothing would be left for
/// braking.
const FULL: f64 = 0.999;

impl Trip {
    fn time(&self, n: usize) -> f64 {
        let sum = self.w[n].sqrt() + self.w[n + 1].sqrt();
        if self.ways[n] > 0.0 { 2.0 * self.ways[n] / sum } else { 0.0 }
    }

    /// Its duration, in s.
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
        // w rises to 100² over 5 units, and falls to 0 over 5: 0.1 s each.
        let trip = cell.trip(0.0, 0.0);
        assert!((trip.duration() - 0.2).abs() < 1e-12);
        // From 100: 5 units at 100 in 0.05 s, then to rest in 0.1 s.
        assert!((cell.trip(10_000.0, 0.0).duration() - 0.15).abs() < 1e-12);
    }

    #[test]
    fn turning_takes_of_what_there_is() {
        // The turn is 0.1 rad per unit: X has 600 − 0.1·w, over 0.6.
        let cell = cell(0.1, 0.1, 70.0);
        assert!((cell.slope(1_000.0) - 500.0 / 0.6).abs() < 1e-9);
        let w = cell.rise(1_000.0);
        assert!((w - 1_000.0 - 2.0 * 0.1 * cell.slope(w)).abs() < 1e-9);
        // As on a circle: 600² − 100² = 591.6².
        assert!((cell.tangent(1_000.0) - 350_000f64.sqrt() / 0.6).abs() < 1e-9);
        assert_eq!(cell.tangent(7_000.0), 0.0);
        // All of the acceleration is available for braking, and `back` and `fall` agree.
        assert!((cell.brake(w) - 1_000.0).abs() < 1e-9);
        let back = cell.back(1_000.0);
        assert!((back - 1_200.0).abs() < 1e-9 && (cell.fall(back) - 1_000.0).abs() < 1e-9);
    }
}
