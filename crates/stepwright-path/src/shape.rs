//! The place of each axis along a piece of a route, and the places at which it crosses the middle between two
//! of its positions.
//!
//! ```text
//!   straight  x(s) = x₀ + t·s                    crossed once, in closed form
//!   round     x(s) = c + r·cos(φ₀ + s/r)         crossed once from one extreme to the next
//! ```
//!
//! An axis steps where it crosses the middle between two positions. Each axis is therefore always at the
//! position nearest to the path, and its mean speed between two steps in the same direction is that of the
//! path. A turn that leads less than a quarter of a step beyond a middle makes no step.

use std::f64::consts::{FRAC_PI_2, PI};

/// A turn of an arc beyond a middle by less than this part of a step makes no step.
const TOUCH: f64 = 0.25;

/// A distance beyond a middle of less than this part of a step is rounding.
const ROUNDED: f64 = 1e-6;

/// Two axes on a circle.
#[derive(Clone, Copy, Debug)]
struct Round {
    axes: [usize; 2],
    radius: f64,
    /// The angle at the beginning, and the radians per unit of the path, positive from the first axis towards
    /// the second.
    from: f64,
    turn: f64,
}

/// A piece of a route: a straight line, or two axes on a circle and the others on a line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape<const N: usize> {
    /// The places of its beginning and its end along the route.
    pub begin: f64,
    pub end: f64,
    /// The place of each axis at the beginning (of a circle, the centre), and its units per unit of the path.
    origin: [f64; N],
    slope: [f64; N],
    round: Option<Round>,
}

impl<const N: usize> Shape<N> {
    /// A straight line between two different places.
    pub fn line(begin: f64, from: [f64; N], to: [f64; N]) -> Shape<N> {
        let way: [f64; N] = std::array::from_fn(|n| to[n] - from[n]);
        let length = norm(&way);
        let slope = way.map(|way| way / length);
        Shape { begin, end: begin + length, origin: from, slope, round: None }
    }

    /// An arc of two axes by `sweep` radians around a centre, which is not their place. The other axes move by
    /// `climb` meanwhile.
    pub fn arc(
        begin: f64,
        from: [f64; N],
        axes: [usize; 2],
        centre: [f64; 2],
        sweep: f64,
        climb: [f64; N],
    ) -> Shape<N> {
        let [x, y] = [from[axes[0]] - centre[0], from[axes[1]] - centre[1]];
        let radius = x.hypot(y);
        let length = (radius * sweep).hypot(norm(&climb));
        let mut origin = from;
        (origin[axes[0]], origin[axes[1]]) = (centre[0], centre[1]);
        let round = Round { axes, radius, from: y.atan2(x), turn: sweep / length };
        let slope = climb.map(|way| way / length);
        Shape { begin, end: begin + length, origin, slope, round: Some(round) }
    }

    pub fn length(&self) -> f64 {
        self.end - self.begin
    }

    /// The radians from its beginning to its end; 0 for a line.
    pub fn sweep(&self) -> f64 {
        self.round.map_or(0.0, |round| (round.turn * self.length()).abs())
    }

    /// Whether two axes are on a circle.
    pub fn is_round(&self) -> bool {
        self.round.is_some()
    }

    /// The change of the direction of each axis per unit of the path, with its sign.
    pub fn curvature(&self, s: f64) -> [f64; N] {
        std::array::from_fn(|axis| match self.circle(axis) {
            Some((Round { radius, from, turn, .. }, ahead)) => {
                -radius * turn * turn * (from - ahead + turn * (s - self.begin)).cos()
            }
            None => 0.0,
        })
    }

    /// The circle that an axis is on, and by how much its angle is ahead of the axis's own.
    fn circle(&self, axis: usize) -> Option<(Round, f64)> {
        let round = self.round?;
        let part = round.axes.iter().position(|known| *known == axis)?;
        Some((round, if part == 0 { 0.0 } else { FRAC_PI_2 }))
    }

    /// The place of an axis.
    pub fn place(&self, axis: usize, s: f64) -> f64 {
        let s = s - self.begin;
        match self.circle(axis) {
            // sin φ = cos(φ − π/2).
            Some((Round { radius, from, turn, .. }, ahead)) => {
                self.origin[axis] + radius * (from - ahead + turn * s).cos()
            }
            None => self.origin[axis] + self.slope[axis] * s,
        }
    }

    /// The units of each axis per unit of the path.
    pub fn direction(&self, s: f64) -> [f64; N] {
        std::array::from_fn(|axis| match self.circle(axis) {
            Some((Round { radius, from, turn, .. }, ahead)) => {
                -radius * turn * (from - ahead + turn * (s - self.begin)).sin()
            }
            None => self.slope[axis],
        })
    }

    /// The largest change of the direction of each axis per unit of the path, and the largest component of the
    /// direction, between two places.
    pub fn bounds(&self, from: f64, to: f64) -> ([f64; N], [f64; N]) {
        let mut bend = [0.0; N];
        let mut tilt = self.slope.map(f64::abs);
        for axis in 0..N {
            let Some((Round { radius, from: phase, turn, .. }, ahead)) = self.circle(axis) else {
                continue;
            };
            let angle = |s: f64| phase - ahead + turn * (s - self.begin);
            let (a, b) = (angle(from), angle(to));
            // |cos| within an interval is at most that of the nearer end over cos(half of it).
            let half = ((b - a).abs() / 2.0).min(FRAC_PI_2).cos().max(1e-9);
            let most = |a: f64, b: f64| (a.abs().max(b.abs()) / half).min(1.0);
            tilt[axis] = (radius * turn).abs() * most(a.sin(), b.sin());
            bend[axis] = radius * turn * turn * most(a.cos(), b.cos());
        }
        (bend, tilt)
    }

    /// The next step of an axis at position `at`, between the places `from` and `to`: its place along the
    /// route, and whether it is forward.
    pub fn step(&self, axis: usize, at: i64, size: f64, from: f64, to: f64) -> Option<(f64, bool)> {
        let middle = |forward: bool| (at as f64 + if forward { 0.5 } else { -0.5 }) * size;
        // The middle that a part without a turn crosses, if any.
        let crossed = |place: f64, least: f64| {
            let least = least * size;
            let up = place > middle(true) + least;
            (up || place < middle(false) - least).then_some(up)
        };
        let Some((round, ahead)) = self.circle(axis) else {
            let forward = crossed(self.place(axis, self.end), ROUNDED)?;
            let s = self.begin + (middle(forward) - self.origin[axis]) / self.slope[axis];
            let s = s.max(from);
            return (s <= to).then_some((s, forward));
        };
        // Mirrored so that the angle grows: cos is even.
        let sign = round.turn.signum();
        let (phase, turn) = (sign * (round.from - ahead), round.turn.abs());
        let mut half = ((phase + turn * (from - self.begin)) / PI).floor();
        loop {
            let extreme = |half: f64| (self.begin + (half * PI - phase) / turn).min(self.end);
            let last = extreme(half + 1.0);
            // Whether the axis is back by the next extreme, or the end.
            let back = crossed(self.place(axis, extreme(half + 2.0)), ROUNDED).is_none();
            let least = if last < self.end && back { TOUCH } else { ROUNDED };
            if let Some(forward) = crossed(self.place(axis, last), least)
                && forward == (half.rem_euclid(2.0) == 1.0)
            {
                let part = ((middle(forward) - self.origin[axis]) / round.radius).clamp(-1.0, 1.0);
                let angle = if forward { PI - part.acos() } else { part.acos() };
                let s = self.begin + (half * PI + angle - phase) / turn;
                let s = s.max(from);
                return (s <= to).then_some((s, forward));
            }
            if last >= to || last >= self.end {
                return None;
            }
            half += 1.0;
        }
    }
}

/// The length of a way.
pub(crate) fn norm<const N: usize>(way: &[f64; N]) -> f64 {
    way.iter().map(|way| way * way).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both axes stay within three quarters of a step of a circle, which ends where it began.
    #[test]
    fn steps_follow_a_circle() {
        for sweep in [2.0 * PI, -2.0 * PI, 5.0, -0.3] {
            let shape = Shape::arc(7.0, [3.0, 1.0], [0, 1], [0.5, -2.0], sweep, [0.0; 2]);
            for axis in 0..2 {
                let size = 0.013;
                let mut at = (shape.place(axis, 7.0) / size).round() as i64;
                let mut s = 7.0;
                // Divided at any places, the steps are the same.
                for to in [7.1, 8.0, 8.0, shape.end] {
                    let to = to.min(shape.end);
                    while let Some((next, forward)) = shape.step(axis, at, size, s, to) {
                        assert!(next >= s && next <= to);
                        s = next;
                        at += if forward { 1 } else { -1 };
                        let off = at as f64 - shape.place(axis, s) / size;
                        let (half, sign) = (off.abs(), if forward { 1.0 } else { -1.0 });
                        assert!((half - 0.5).abs() < 1e-6 && off * sign > 0.0, "{off} {forward}");
                    }
                    s = to;
                }
                assert!((at as f64 - shape.place(axis, shape.end) / size).abs() < 0.501);
            }
        }
    }

    /// The bounds of an arc hold at every place of it.
    #[test]
    fn bounds_hold() {
        let shape = Shape::arc(0.0, [3.0, 1.0, 0.0], [0, 1], [0.5, -2.0], 6.0, [0.0, 0.0, 2.0]);
        for cell in 0..40 {
            let place = |n: i32| shape.end * f64::from(n) / 4_000.0;
            let (bend, tilt) = shape.bounds(place(cell * 100), place(cell * 100 + 100));
            for n in 0..100 {
                let (s, ds) = (place(cell * 100 + n), shape.end / 4_000.0);
                let (here, there) = (shape.direction(s), shape.direction(s + ds));
                assert!((norm(&here) - 1.0).abs() < 1e-12);
                for axis in 0..3 {
                    assert!(here[axis].abs() <= tilt[axis] * 1.000_001);
                    assert!((there[axis] - here[axis]).abs() <= bend[axis] * ds * 1.000_001);
                }
            }
        }
    }
}
