//! The check of the law of jerk: the speed of every axis stays within S/2 of some speed u with |u'| ≤ A and
//! |u''| ≤ J.
//!
//! The state of the check is the set of (u, u') that are possible now, a convex polygon for each axis. In
//! time the set drifts, and widens by what |u''| ≤ J can reach. The speed of the axis clips the parts that
//! are too far away. The law is broken when the set is empty.
//!
//! ```text
//!   u'  A ┤      ╱▔▔╲            later   (u, a) → (u + a·T, a), and ± (J·T²/2, J·T)
//!         │    ╱      ▏          seen    v − S/2 ≤ u ≤ v + S/2,   −A ≤ a ≤ A
//!         │   ▕     ╱
//!         │    ╲__╱
//!         └────┼──┼──┼──── u
//!            v−S/2 v v+S/2
//! ```
//!
//! The set is never too large: the jerk of u is constant within a time step, which is short beside √(S/J), and
//! dropping surplus corners makes the set smaller. A speed that passes the check therefore keeps the law. This
//! law implies the law of speed ([`Bucket`](crate::bucket::Bucket)): u changes by at most A·t, and the axis is
//! within S/2 of it.

use crate::piece::{Moment, Piece};
use crate::route::AxisPace;
use crate::shape::Shape;

/// The most corners of a polygon between two steps.
const CORNERS: usize = 12;

/// The most corners during a step: two more by the reach of u'', one more by each of four cuts.
const ROOM: usize = CORNERS + 6;

/// The part of the jump that is used. The rest is for the times between two samples.
const USED: f64 = 0.992;

/// The same in a plan. The executed course is sampled at other times, and has more room.
const PLANNED: f64 = 0.982;

/// The relative rounding error of a limit.
const ROUNDED: f64 = 1e-9;

/// The rounding error of a distance, in units of the jump and the acceleration.
const NEAR: f64 = 1e-6;

/// The longest time step, as a part of √(S/J). Within a step u may approach a bound and return: with a jerk J,
/// and an axis with as much jerk the other way, by J·T²/4, which is 0.008·S.
const SHORT: f64 = 0.18;

/// The number of time steps of a constant speed after which u may be any constant within the bounds. 6.4·√(S/J)
/// would be enough: in that time u can stop within S, and reach any place in another 2·√(S/J).
const SETTLED: u32 = 40;

/// u and u'.
type Corner = [f64; 2];

#[inline]
fn cross(a: Corner, b: Corner) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

#[inline]
fn less(a: Corner, b: Corner) -> Corner {
    [a[0] - b[0], a[1] - b[1]]
}

/// A convex polygon with counterclockwise corners. It may have only one or two corners.
#[derive(Clone, Copy, Debug)]
struct Polygon {
    corners: [Corner; ROOM],
    count: usize,
}

impl Polygon {
    const NONE: Polygon = Polygon { corners: [[0.0; 2]; ROOM], count: 0 };

    fn line(from: f64, to: f64) -> Polygon {
        let mut line = Polygon::NONE;
        line.push([from, 0.0]);
        line.push([to, 0.0]);
        line
    }

    fn push(&mut self, corner: Corner) {
        if let Some(place) = self.corners.get_mut(self.count) {
            *place = corner;
            self.count += 1;
        }
    }

    fn known(&self) -> &[Corner] {
        self.corners.get(..self.count).unwrap_or(&[])
    }

    /// Writes the polygon after a time to `later`: it drifts, and is swept along ±reach.
    fn later(&self, time: f64, jerk: f64, later: &mut Polygon) {
        let reach = [jerk * time * time / 2.0, jerk * time];
        let mut moved = [[0.0; 2]; ROOM];
        let mut sides = [0.0; ROOM];
        later.count = 0;
        let Some(mut next) = self.known().first().copied() else { return };
        next[0] += next[1] * time;
        for n in (0..self.count).rev() {
            let [u, a] = self.corners[n];
            moved[n] = [u + a * time, a];
            sides[n] = cross(reach, less(next, moved[n]));
            next = moved[n];
        }
        let (moved, sides) = (&moved[..self.count], &mut sides[..self.count]);
        // An edge along the reach belongs to the side before it.
        let Some(mut before) = sides.iter().copied().rev().find(|side| *side != 0.0) else {
            // All corners lie on a line along the reach, or there is only one.
            let along = |corner: &Corner| corner[0] * reach[0] + corner[1] * reach[1];
            let ends = moved.iter().copied();
            let low = ends.clone().min_by(|a, b| along(a).total_cmp(&along(b)));
            let high = ends.max_by(|a, b| along(a).total_cmp(&along(b)));
            if let (Some(low), Some(high)) = (low, high) {
                later.push(less(low, reach));
                later.push([high[0] + reach[0], high[1] + reach[1]]);
            }
            return;
        };
        for (corner, side) in moved.iter().zip(sides) {
            let next = if *side == 0.0 { before } else { *side };
            // Each side moves outwards: ahead or back along the reach, by the way it faces.
            let ahead = [corner[0] + reach[0], corner[1] + reach[1]];
            let back = less(*corner, reach);
            later.push(if before > 0.0 { ahead } else { back });
            if (before > 0.0) != (next > 0.0) {
                later.push(if next > 0.0 { ahead } else { back });
            }
            before = next;
        }
    }

    /// Writes the part of the polygon with low ≤ corner\[`part`\] ≤ high to `left`.
    fn clip(&self, part: usize, low: f64, high: f64, left: &mut Polygon) {
        left.count = 0;
        let corners = self.known();
        let Some(mut before) = corners.last() else { return };
        for corner in corners {
            let (from, to) = (before[part], corner[part]);
            let rises = from < to;
            for bound in if rises { [low, high] } else { [high, low] } {
                if (from < bound && to > bound) || (from > bound && to < bound) {
                    let share = (bound - from) / (to - from);
                    let way = less(*corner, *before);
                    let mut cut = [before[0] + way[0] * share, before[1] + way[1] * share];
                    cut[part] = bound;
                    left.push(cut);
                }
            }
            if (low..=high).contains(&to) {
                left.push(*corner);
            }
            before = corner;
        }
    }

    /// Whether all corners are within these bounds.
    fn within(&self, part: usize, low: f64, high: f64) -> bool {
        self.known().iter().all(|corner| corner[part] >= low && corner[part] <= high)
    }

    /// Clips the polygon to speeds within `near` of `v`; false if nothing is left.
    fn see(&mut self, v: f64, near: f64, accel: f64) -> bool {
        for (part, low, high) in [(0, v - near, v + near), (1, -accel, accel)] {
            if !self.within(part, low, high) {
                let before = *self;
                before.clip(part, low, high, self);
            }
        }
        self.simplify();
        self.count > 0
    }

    /// Lets a time pass, then clips to speeds within `near` of `v`; false if nothing is left.
    fn step(&mut self, time: f64, v: f64, limits: &Limits) -> bool {
        let Limits { near, accel, jerk } = *limits;
        let mut later = Polygon::NONE;
        self.later(time, jerk, &mut later);
        later.clip(0, v - near, v + near, self);
        if !self.within(1, -accel, accel) {
            later = *self;
            later.clip(1, -accel, accel, self);
        }
        self.simplify();
        self.count > 0
    }

    /// Whether this polygon contains all corners of another one, but for rounding; false if this one has no
    /// area.
    fn contains(&self, other: &Polygon, limits: &Limits) -> bool {
        let scale = |corner: Corner| [corner[0] / limits.near, corner[1] / limits.accel];
        let corners = self.known();
        let Some(mut before) = corners.last() else { return false };
        self.count > 2
            && other.count > 0
            && corners.iter().all(|corner| {
                let edge = scale(less(*corner, *before));
                let least = -NEAR * edge[0].hypot(edge[1]);
                let from = std::mem::replace(&mut before, corner);
                other.known().iter().all(|other| cross(edge, scale(less(*other, *from))) >= least)
            })
    }

    /// Drops surplus corners, each time the corner that costs the least area.
    fn simplify(&mut self) {
        if self.count <= CORNERS {
            return;
        }
        let mut areas = [0.0; ROOM];
        for (n, area) in areas.iter_mut().enumerate().take(self.count) {
            *area = self.beside(n);
        }
        while self.count > CORNERS {
            let (mut least, mut area) = (0, f64::INFINITY);
            for (n, known) in areas[..self.count].iter().enumerate() {
                if *known < area {
                    (least, area) = (n, *known);
                }
            }
            for n in least + 1..self.count {
                self.corners[n - 1] = self.corners[n];
                areas[n - 1] = areas[n];
            }
            self.count -= 1;
            for beside in [least.checked_sub(1).unwrap_or(self.count - 1), least % self.count] {
                areas[beside] = self.beside(beside);
            }
        }
    }

    /// The area that dropping a corner would cost, doubled.
    fn beside(&self, n: usize) -> f64 {
        let a = self.corners[n.checked_sub(1).unwrap_or(self.count - 1)];
        let c = self.corners[if n + 1 < self.count { n + 1 } else { 0 }];
        cross(less(self.corners[n], a), less(c, a)).abs()
    }
}

/// The state of the check: the possible (u, u') of each axis.
#[derive(Clone, Debug)]
pub(crate) struct Lens<const N: usize> {
    axes: [Polygon; N],
    limits: [Limits; N],
    /// The longest time step of each axis, in s.
    moments: [f64; N],
}

#[derive(Clone, Copy, Debug)]
struct Limits {
    near: f64,
    accel: f64,
    jerk: f64,
}

impl Limits {
    /// The set after a long time at this speed.
    fn settled(&self, v: f64) -> Polygon {
        Polygon::line(v - self.near, v + self.near)
    }
}

impl<const N: usize> Lens<N> {
    /// The state after a long rest.
    pub fn new(axes: &[AxisPace; N], jerk: &[f64; N]) -> Lens<N> {
        let limits: [Limits; N] = std::array::from_fn(|n| {
            let AxisPace { accel, jump, .. } = axes[n];
            let more = 1.0 + ROUNDED;
            Limits { near: USED * jump / 2.0 * more, accel: accel * more, jerk: jerk[n] }
        });
        let moments = std::array::from_fn(|n| SHORT * (axes[n].jump / jerk[n]).sqrt());
        let axes = limits.map(|limits| Polygon::line(-limits.near, limits.near));
        Lens { axes, limits, moments }
    }

    /// The state for a plan from here on.
    pub fn planned(&self) -> Lens<N> {
        self.using(PLANNED / USED)
    }

    /// Turns the state of a plan into one for the executed course.
    pub fn made(&self) -> Lens<N> {
        self.using(USED / PLANNED)
    }

    fn using(&self, part: f64) -> Lens<N> {
        let mut lens = self.clone();
        lens.limits.iter_mut().for_each(|limits| limits.near *= part);
        lens
    }

    /// Whether this set contains all of another one, but for rounding.
    pub fn contains(&self, other: &Lens<N>) -> bool {
        let each = self.axes.iter().zip(&other.axes).zip(&self.limits);
        each.into_iter().all(|((this, other), limits)| this.contains(other, limits))
    }

    /// Sets the state after a long time at this speed.
    fn settle(&mut self, v: &[f64; N]) {
        for ((polygon, limits), v) in self.axes.iter_mut().zip(&self.limits).zip(v) {
            *polygon = limits.settled(*v);
        }
    }

    /// Sets the largest set possible at this speed, to continue where the law is broken.
    pub fn forget(&mut self, v: &[f64; N]) {
        for ((polygon, limits), v) in self.axes.iter_mut().zip(&self.limits).zip(v) {
            let ([low, high], accel) = ([v - limits.near, v + limits.near], limits.accel);
            *polygon = Polygon::NONE;
            for corner in [[low, -accel], [high, -accel], [high, accel], [low, accel]] {
                polygon.push(corner);
            }
        }
    }

    /// Follows a rest of this time, in s.
    pub fn wait(&mut self, time: f64) {
        if self.steady(time, &[0.0; N]).is_err() {
            // It is at rest already.
            self.settle(&[0.0; N]);
        }
    }

    fn see(&mut self, v: &[f64; N]) -> bool {
        let mut left = true;
        for ((polygon, limits), v) in self.axes.iter_mut().zip(&self.limits).zip(v) {
            left &= polygon.see(*v, limits.near, limits.accel);
        }
        left
    }

    /// Lets a time pass, then clips all axes at these speeds; false if the law is broken.
    fn step(&mut self, time: f64, v: &[f64; N]) -> bool {
        let mut left = true;
        for ((polygon, limits), v) in self.axes.iter_mut().zip(&self.limits).zip(v) {
            left &= polygon.step(time, *v, limits);
        }
        left
    }

    /// Follows constant speeds for a time. The error is the time after which the law is broken.
    fn steady(&mut self, time: f64, v: &[f64; N]) -> Result<(), f64> {
        let mut broken = f64::INFINITY;
        for axis in 0..N {
            let (polygon, limits, v) = (&mut self.axes[axis], &self.limits[axis], v[axis]);
            let moments = (time / self.moments[axis]).ceil();
            let settled = moments > f64::from(SETTLED);
            let (count, each) = if settled {
                (SETTLED, self.moments[axis])
            } else {
                (moments as u32, time / moments.max(1.0))
            };
            let first = (1..=count).find(|_| !polygon.step(each, v, limits));
            match first {
                Some(n) => broken = broken.min(f64::from(n) * each),
                None if settled => *polygon = limits.settled(v),
                None => {}
            }
        }
        if broken < f64::INFINITY { Err(broken) } else { Ok(()) }
    }

    /// Follows a slow turn at a constant speed for a long time. The speed of each axis is taken as constant,
    /// and the set is narrower by the change of that speed. Returns false, and changes nothing, if the change
    /// is too large, or if the law is broken.
    fn turn(&mut self, shape: &Shape<N>, from: Moment, time: f64) -> bool {
        let way = from.v * time;
        let (bend, _) = shape.bounds(from.s, from.s + way);
        let mut lens = self.clone();
        for (limits, bend) in lens.limits.iter_mut().zip(bend) {
            let off = bend * from.v * way / 2.0;
            if off > limits.near / 4.0 {
                return false;
            }
            limits.near -= off;
        }
        let middle = shape.direction(from.s + way / 2.0).map(|part| part * from.v);
        let kept = lens.steady(time, &middle).is_ok();
        if kept {
            self.axes = lens.axes;
        }
        kept
    }

    /// Follows a piece along a shape.
    ///
    /// # Errors
    /// The place along the route where the law is broken first.
    pub fn follow(&mut self, shape: &Shape<N>, piece: &Piece) -> Result<(), f64> {
        let (from, time) = (piece.from, piece.to.t - piece.from.t);
        let mut direction = shape.direction(from.s);
        if !self.see(&direction.map(|part| part * from.v)) {
            return Err(from.s);
        }
        if piece.jerk == 0.0 && from.a == 0.0 && !shape.is_round() {
            let speeds = direction.map(|part| part * from.v);
            return self.steady(time, &speeds).map_err(|after| from.s + from.v * after);
        }
        let moment = self.moments.iter().copied().fold(f64::INFINITY, f64::min);
        let end = f64::from(SETTLED) * moment;
        let level = piece.jerk == 0.0 && from.a == 0.0;
        let mut begun = 0.0;
        if level && time > 4.0 * end && self.turn(shape, from, time - end) {
            begun = time - end;
        }
        let moments = ((time - begun) / moment).ceil().max(1.0);
        let each = (time - begun) / moments;
        let mut n = 0.0;
        while n < moments && each > 0.0 {
            n += 1.0;
            let here =
                if n == moments { piece.to } else { from.after(piece.jerk, begun + n * each) };
            if shape.is_round() {
                direction = shape.direction(here.s);
            }
            if !self.step(each, &direction.map(|part| part * here.v)) {
                return Err(here.s);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: AxisPace =
        AxisPace { step: 0.01, speed: 300.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };

    /// u has to move by S between two jumps of S: in √(2·S/J) = 31.6 ms, less for the unused part.
    #[test]
    fn two_jumps_need_a_time_between() {
        let jump = USED * 5.0;
        for (time, kept) in [(0.031, false), (0.032, true), (10.0, true)] {
            let mut lens = Lens::new(&[AXIS], &[10_000.0]);
            assert!(lens.see(&[0.0]) && lens.see(&[jump]));
            assert!(lens.steady(time, &[jump]).is_ok());
            assert_eq!(lens.see(&[2.0 * jump]), kept, "{time}");
        }
        // A jump of more than S is never allowed.
        let mut lens = Lens::new(&[AXIS], &[10_000.0]);
        assert!(lens.see(&[0.0]) && !lens.see(&[5.01]));
    }

    /// A jump of the acceleration by Δ needs a jump of Δ²/8J: Δ is at most √(8·S·J) = 632 mm/s².
    #[test]
    fn a_step_of_acceleration_takes_of_the_jump() {
        for (accel, kept) in [(600.0, true), (660.0, false)] {
            let mut lens = Lens::new(&[AXIS], &[10_000.0]);
            // u may begin to rise before the axis does.
            let mut left = lens.steady(0.1, &[0.0]).is_ok();
            for n in 1..=100 {
                left &= lens.step(0.001, &[accel * 0.001 * f64::from(n)]);
            }
            assert_eq!(left, kept, "{accel}");
        }
    }
}
