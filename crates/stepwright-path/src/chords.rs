//! How a route turns at a joint of chords, by more than the two chords that meet there.
//!
//! Places in a file are rounded, and a curve may contain a very short chord between longer ones. The directions
//! of such chords are inexact, and seem to turn far more from chord to chord than the curve does. No axis needs
//! to follow these turns: its speed may deviate by what the jump hides. The speed u is therefore assumed to
//! turn with the mean direction over r units on each side of the joint J,
//!
//! ```text
//!      ╱╲__╱╲    ╱╲ J  ╱╲    ╱╲__╱╲        D  the way of each axis on either side
//!     ╱      ╲__╱  ╲__╱  ╲__╱              I  its sum over the units from J
//!     ┆←─────── r ──┆── r ───────→┆
//!
//!   dt/ds = (D₊ − D₋)/r²                   how it turns
//!   t     = (I₊ + I₋)/r²                   its direction
//! ```
//!
//! which is the mean with a weight that falls linearly from J to both ends. The joint may be passed at
//!
//! ```text
//!   v²·|dt/ds|          ≤ A                as a curve
//!   v·|direction − t|   ≤ S/2              of both chords, and a part of S
//! ```
//!
//! with the r that allows the highest speed. If places are off by ε, the turning is off by some 2·ε/r². These
//! bounds are for speed. Each plan is checked against the law with the actual directions.

use std::collections::VecDeque;

use crate::joint::Joint;
use crate::route::AxisPace;
use crate::shape::Shape;

/// The part of S that is used where chords are rough. The rest is for speeding up meanwhile.
const PART: f64 = 0.87;

/// r is doubled if that raises w by this factor.
const GAIN: f64 = 1.05;

/// Where chords are rough, the largest r is used that allows w to be the ordered one times this factor.
const ENOUGH: f64 = 1.1;

/// Chords whose lengths differ by at most this factor count as equally long.
const UNEQUAL: f64 = 1.5;

/// Whether one of two chords of a curve is so much shorter than the other that the curve seems to turn more
/// than it does.
pub(crate) fn is_unequal<const N: usize>(joint: &Joint<N>, chords: [&Shape<N>; 2]) -> bool {
    let [before, behind] = chords.map(Shape::length);
    joint.turns() && before.max(behind) > UNEQUAL * before.min(behind)
}

/// The most chords before a joint that are considered.
const SEEN: usize = 96;

/// The chords before a joint, the nearest first, back to a corner or an arc.
#[derive(Clone, Debug, Default)]
pub(crate) struct Before<const N: usize> {
    chords: VecDeque<(Shape<N>, bool)>,
    rough: usize,
}

impl<const N: usize> Before<N> {
    /// Adds a chord, and whether the joint at its beginning turns there and back.
    pub fn push(&mut self, chord: Shape<N>, rough: bool) {
        self.chords.push_front((chord, rough));
        self.rough += usize::from(rough);
        if self.chords.len() > SEEN
            && let Some((_, rough)) = self.chords.pop_back()
        {
            self.rough -= usize::from(rough);
        }
    }

    pub fn clear(&mut self) {
        self.chords.clear();
        self.rough = 0;
    }

    pub fn iter(&self) -> impl Iterator<Item = &Shape<N>> + Clone {
        self.chords.iter().map(|(chord, _)| chord)
    }

    /// The number of their joints that turn there and back.
    pub fn rough(&self) -> usize {
        self.rough
    }
}

/// The way from a joint over the chords on one side.
struct Arm<'a, const N: usize, I: Iterator<Item = &'a Shape<N>>> {
    chords: I,
    /// The length so far, the distance of each axis in it, and the integral of that distance.
    gone: f64,
    way: [f64; N],
    sum: [f64; N],
    /// The direction of the present chord, and its remaining length.
    direction: [f64; N],
    left: f64,
}

impl<'a, const N: usize, I: Iterator<Item = &'a Shape<N>>> Arm<'a, N, I> {
    fn new(chords: I) -> Self {
        Arm { chords, gone: 0.0, way: [0.0; N], sum: [0.0; N], direction: [0.0; N], left: 0.0 }
    }

    /// Continues to `r` units from the joint; `None` if the chords end before.
    fn to(&mut self, r: f64) -> Option<()> {
        while self.gone < r {
            if self.left <= 0.0 {
                let chord = self.chords.next()?;
                (self.direction, self.left) = (chord.direction(chord.begin), chord.length());
            }
            let part = self.left.min(r - self.gone);
            for axis in 0..N {
                let way = self.direction[axis] * part;
                self.sum[axis] += (self.way[axis] + way / 2.0) * part;
                self.way[axis] += way;
            }
            self.gone = if part < self.left { r } else { self.gone + part };
            self.left -= part;
        }
        Some(())
    }
}

/// How a joint of chords is judged.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View<'a, const N: usize> {
    pub axes: &'a [AxisPace; N],
    /// The ordered speed.
    pub feed: f64,
    /// The largest r.
    pub reach: f64,
    /// Whether the chords turn there and back.
    pub rough: bool,
    /// Whether corners are limited by the jump, not by junction deviation.
    pub strict: bool,
}

impl<const N: usize> View<'_, N> {
    /// The joint as judged with the chords before it, the nearest first, and those behind it.
    pub fn joint<'a>(
        &self,
        joint: &Joint<N>,
        before: impl Iterator<Item = &'a Shape<N>> + Clone,
        behind: impl Iterator<Item = &'a Shape<N>> + Clone,
    ) -> Joint<N> {
        let mut best = *joint;
        let (Some(last), Some(first)) = (before.clone().next(), behind.clone().next()) else {
            return best;
        };
        if !(self.rough || is_unequal(joint, [last, first])) {
            return best;
        }
        let enough = if self.rough { ENOUGH * self.feed * self.feed } else { f64::INFINITY };
        let ends = [last.direction(last.end), first.direction(first.begin)];
        let lengths = [last.length(), first.length()];
        let mut arms = (Arm::new(before), Arm::new(behind));
        let mut r = (lengths[0] + lengths[1]) / 2.0;
        while r <= self.reach
            && (self.rough || best.cap < joint.top)
            && arms.0.to(r).is_some()
            && arms.1.to(r).is_some()
        {
            let turn = std::array::from_fn(|n| (arms.1.way[n] - arms.0.way[n]) / (r * r));
            let mean = std::array::from_fn(|n| (arms.1.sum[n] + arms.0.sum[n]) / (r * r));
            let [hidden, curve] = self.caps(&ends, &mean, &turn);
            let hidden = if self.strict { hidden } else { joint.alone };
            if hidden < (GAIN * best.cap).min(enough) && r > lengths[0].max(lengths[1]) {
                break;
            }
            let cap = hidden.min(curve);
            if cap >= (GAIN * best.cap).min(enough) {
                let zones = lengths.map(|length| r.min(length / 2.0));
                best = Joint { cap, ..best.turning(turn, [&ends[0], &ends[1]], zones) };
            }
            r *= 2.0;
        }
        best
    }

    /// The largest w by what the jump hides, and as a curve.
    fn caps(&self, ends: &[[f64; N]; 2], mean: &[f64; N], turn: &[f64; N]) -> [f64; 2] {
        let part = if self.rough { PART } else { 1.0 };
        let (mut hidden, mut curve) = (f64::INFINITY, f64::INFINITY);
        for (n, axis) in self.axes.iter().enumerate() {
            let off = ends.map(|end| (end[n] - mean[n]).abs());
            hidden = hidden.min(part * axis.jump / 2.0 / off[0].max(off[1]));
            curve = curve.min(axis.accel / turn[n].abs());
        }
        [hidden * hidden, curve]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: AxisPace =
        AxisPace { step: 0.01, speed: 300.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };

    /// Chords through these places.
    fn chords(places: &[[f64; 2]]) -> Vec<Shape<2>> {
        let mut begin = 0.0;
        let each = places.windows(2).map(|two| {
            let chord = Shape::line(begin, two[0], two[1]);
            begin = chord.end;
            chord
        });
        each.collect()
    }

    /// The w of a joint by itself, and as judged with its chords.
    fn seen(chords: &[Shape<2>], n: usize, rough: bool) -> [f64; 2] {
        let [before, behind] = [&chords[n - 1], &chords[n]];
        let ends = [&before.direction(before.end), &behind.direction(behind.begin)];
        let lengths = [before.length(), behind.length()];
        let joint = Joint::new(ends, lengths, 200.0, &[AXIS; 2], None);
        let view = View { axes: &[AXIS; 2], feed: 100.0, reach: 1.0, rough, strict: true };
        let known = view.joint(&joint, chords[..n].iter().rev(), chords[n..].iter());
        [joint.cap, known.cap]
    }

    #[test]
    fn an_arm_by_hand() {
        let chords = chords(&[[0.0, 0.0], [3.0, 4.0], [3.0, 6.0]]);
        let mut arm = Arm::new(chords.iter());
        arm.to(2.5).unwrap();
        assert_eq!((arm.way, arm.sum), ([1.5, 2.0], [1.875, 2.5]));
        arm.to(6.0).unwrap();
        // 3/5 and 4/5 over 5 units; then 0 of X and 1 of Y over 1 unit.
        assert_eq!(arm.way, [3.0, 5.0]);
        assert!((arm.sum[0] - (7.5 + 3.0)).abs() < 1e-12);
        assert!((arm.sum[1] - (10.0 + 4.5)).abs() < 1e-12);
        assert!(arm.to(7.5).is_none());
    }

    /// A circle of 5 mm in chords of 0.5 mm: √(1000·5) = 70.7 mm/s as a curve, 5/0.1 = 50 by the jump. With a
    /// chord of 10 µm, it looks like a tight bend.
    #[test]
    fn a_short_chord_turns_as_its_curve() {
        let place = |angle: f64| [5.0 * angle.cos(), 5.0 * angle.sin()];
        let angles = [0.0, 0.1, 0.2, 0.202, 0.302, 0.402];
        let chords = chords(&angles.map(place));
        for n in [2, 3] {
            let [alone, known] = seen(&chords, n, false).map(f64::sqrt);
            assert!(alone < 20.0 && (49.0..55.0).contains(&known), "{alone} {known}");
        }
        // Chords of equal length keep their limit.
        let chords = chords_of_one_length(place);
        let [alone, known] = seen(&chords, 3, false);
        assert_eq!(alone, known);
    }

    fn chords_of_one_length(place: impl Fn(f64) -> [f64; 2]) -> Vec<Shape<2>> {
        let places: Vec<_> = (0..8).map(|n| place(0.1 * f64::from(n))).collect();
        chords(&places)
    }

    /// A straight line in chords of 0.1 mm whose places are off by 1 µm: it turns by 20 mrad from chord to
    /// chord. At 100 mm/s that is 2 mm/s of an axis, which the jump hides.
    #[test]
    fn a_rough_line_is_a_line() {
        let places: Vec<[f64; 2]> =
            (0..40).map(|n| [0.1 * f64::from(n), 0.001 * f64::from(n % 2)]).collect();
        let chords = chords(&places);
        let [alone, known] = seen(&chords, 20, true).map(f64::sqrt);
        assert!((alone - (1_000.0f64 * 0.1 / 0.02).sqrt()).abs() < 0.1, "{alone}");
        assert!(known > 100.0, "{known}");
        // The jump does not hide ten times as much.
        let places: Vec<[f64; 2]> = places.iter().map(|[x, y]| [*x, 10.0 * y]).collect();
        let [alone, known] = seen(&self::chords(&places), 20, true);
        assert!(alone == known && alone < 25.0 * 25.0, "{alone} {known}");
    }
}
