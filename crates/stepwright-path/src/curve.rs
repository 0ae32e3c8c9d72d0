//! The places along a path at which each axis steps.
//!
//! **Lines.** An axis with n steps divides the line into n equal parts: its first step is one part after the
//! beginning, its last step at the end.
//!
//! ```text
//!   X  ┊    │    │    │    │    │    │
//!   Y  ┊       │       │       │     │   (n equal parts)
//!      begin                         end
//! ```
//!
//! The steps of each axis are its own profile, scaled by its share of the path: no Bresenham, no unevenness.
//! The path begins at rest, and so does each axis. Its first step comes after the first interval of its own
//! ramp, even if another path has ended a moment before.
//!
//! **Arcs.** An axis steps where the circle crosses the middle between two of its positions, which is found in
//! closed form. Both axes are therefore always at the position nearest to the circle. Where the circle only
//! touches a middle, the crossing and its return are left out.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::pace::Unplannable;

/// A step: its place along the path, and its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Units from the beginning.
    pub at: f64,
    /// Whether the step is forward.
    pub forward: bool,
}

/// The marks of one axis, from the beginning to the end.
#[derive(Clone, Debug)]
pub struct Marks(Kind);

#[derive(Clone, Debug)]
enum Kind {
    Even(Even),
    Round(Round),
}

/// One axis of a line: mark n is at n of these parts of the way from `first` to `last`.
#[derive(Clone, Debug)]
struct Even {
    first: f64,
    last: f64,
    parts: u32,
    /// The numbers of the next mark, and of the one behind the last.
    next: u32,
    end: u32,
    forward: bool,
}

/// One axis of an arc: its position in steps is c + r·cos φ, where φ begins at `from` and changes by `sweep`.
#[derive(Clone, Debug)]
struct Round {
    c: f64,
    r: f64,
    from: f64,
    sweep: f64,
    /// Units of the path per radian.
    radius: f64,
    /// The radians passed so far.
    gone: f64,
    /// The position in steps, relative to the beginning.
    at: i64,
}

impl Marks {
    /// The steps of an axis of a line of this length, the last at its end.
    fn along(steps: i32, length: f64) -> Marks {
        Marks::onward(steps.into(), 0.0, length, 0.0)
    }

    /// The shortest distance along the path from one step to the next; of an arc it may be a little more.
    /// Infinite without steps.
    pub(crate) fn closest(&self) -> f64 {
        match &self.0 {
            Kind::Even(even) if even.next >= even.end => f64::INFINITY,
            Kind::Even(even) => (even.last - even.first) / f64::from(even.parts),
            Kind::Round(round) => round.radius / round.r / round.steepest(),
        }
    }

    /// The marks of `steps` steps up to `last`, of an axis whose last step was at `first`. No mark is before
    /// `least`: if the first one would be, it is at `least`, and the others are evenly spaced from there on.
    pub(crate) fn onward(steps: i64, first: f64, last: f64, least: f64) -> Marks {
        // The difference of two 32-bit numbers.
        let end = u32::try_from(steps.unsigned_abs()).unwrap_or(u32::MAX);
        let forward = steps > 0;
        let even = if end > 1 && first + (last - first) / f64::from(end) < least {
            Even { first: least, last, parts: end - 1, next: 0, end, forward }
        } else {
            let end = end.saturating_add(1);
            Even { first, last, parts: end - 1, next: 1, end, forward }
        };
        Marks(Kind::Even(even))
    }
}

/// A straight line of N axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<const N: usize> {
    /// The steps of each axis.
    pub steps: [i32; N],
    /// The length of a step of each axis, in units.
    pub step: [f64; N],
}

impl<const N: usize> Line<N> {
    /// Its length.
    pub fn length(&self) -> f64 {
        let ways = self.steps.iter().zip(&self.step).map(|(n, d)| f64::from(*n) * d);
        ways.map(|way| way * way).sum::<f64>().sqrt()
    }

    /// The marks of each axis.
    ///
    /// # Errors
    /// [`Unplannable`] if no axis has a step to make, or the length of a step is not above 0.
    pub fn marks(&self) -> Result<[Marks; N], Unplannable> {
        if self.step.iter().any(|d| !(*d > 0.0 && d.is_finite())) {
            return Err(Unplannable::Step);
        }
        let length = self.length();
        if !(length > 0.0 && length.is_finite()) {
            return Err(Unplannable::Length);
        }
        Ok(self.steps.map(|steps| Marks::along(steps, length)))
    }
}

/// An arc of two axes from their present place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// The centre, in units from the present place.
    pub centre: [f64; 2],
    /// The angle in radians, positive from the first axis towards the second. 2π is a full circle; several
    /// turns are allowed.
    pub sweep: f64,
    /// The length of a step of each axis, in units.
    pub step: [f64; 2],
}

impl Arc {
    /// Its radius.
    pub fn radius(&self) -> f64 {
        self.centre[0].hypot(self.centre[1])
    }

    /// Its length.
    pub fn length(&self) -> f64 {
        self.radius() * self.sweep.abs()
    }

    /// The marks of both axes.
    ///
    /// # Errors
    /// [`Unplannable`] if the arc has no length, if its radius is smaller than a step, or if it has more steps
    /// than can be counted, along the arc or from its centre.
    pub fn marks(&self) -> Result<[Marks; 2], Unplannable> {
        if self.step.iter().any(|d| !(*d > 0.0 && d.is_finite())) {
            return Err(Unplannable::Step);
        }
        let (radius, length) = (self.radius(), self.length());
        if !(length > 0.0 && length.is_finite()) {
            return Err(Unplannable::Length);
        }
        if self.step.iter().any(|d| radius < *d) {
            return Err(Unplannable::Radius);
        }
        // So far from the centre, neighbouring positions cannot be told apart either.
        if self.step.iter().any(|d| length.max(radius) / d > f64::from(i32::MAX)) {
            return Err(Unplannable::TooLong);
        }
        let start = (-self.centre[1]).atan2(-self.centre[0]);
        let axis = |n: usize, from: f64| {
            let (c, r) = (self.centre[n] / self.step[n], radius / self.step[n]);
            Marks(Kind::Round(Round { c, r, from, sweep: self.sweep, radius, gone: 0.0, at: 0 }))
        };
        // sin φ = cos(φ − π/2).
        Ok([axis(0, start), axis(1, start - FRAC_PI_2)])
    }
}

/// A circle that leads beyond the middle between two positions by less than this, in steps, only touches it.
const TOUCH: f64 = 0.25;

impl Round {
    /// The largest part of the speed along the arc that the axis has: |sin φ|, at an end of the arc, or 1 where
    /// the arc passes a quarter of a turn.
    fn steepest(&self) -> f64 {
        let (from, to) = (self.from, self.from + self.sweep);
        let quarter = |angle: f64| ((angle - FRAC_PI_2) / PI).floor();
        if quarter(from) != quarter(to) { 1.0 } else { from.sin().abs().max(to.sin().abs()) }
    }

    /// The next crossing of a middle.
    fn next(&mut self) -> Option<Mark> {
        let back = self.sweep < 0.0;
        loop {
            // Mirrored so that the angle grows: cos is even.
            let angle = if back { -self.from } else { self.from } + self.gone;
            let turn = angle.rem_euclid(TAU);
            // The axis falls from 0 to π, and rises from π to 2π.
            let rising = turn >= PI;
            let extreme = if rising { self.c + self.r } else { self.c - self.r };
            let middle = self.at as f64 + if rising { 0.5 } else { -0.5 };
            let way = if rising { extreme - middle } else { middle - extreme };
            let cos = (middle - self.c) / self.r;
            let half = if rising {
                TAU - cos.clamp(-1.0, 1.0).acos()
            } else {
                cos.clamp(-1.0, 1.0).acos()
            };
            if way > TOUCH && half - turn > -1e-9 {
                let gone = self.gone + (half - turn).max(0.0);
                if gone > self.sweep.abs() {
                    return None;
                }
                self.gone = gone;
                self.at += if rising { 1 } else { -1 };
                return Some(Mark { at: gone * self.radius, forward: rising });
            }
            // No crossing is left before the extreme: continue there.
            let end = if rising { TAU } else { PI };
            self.gone += (end - turn).max(1e-12);
            if self.gone > self.sweep.abs() {
                return None;
            }
        }
    }
}

impl Iterator for Even {
    type Item = Mark;

    fn next(&mut self) -> Option<Mark> {
        let Even { first, last, parts, next: n, end, forward } = *self;
        if n >= end {
            return None;
        }
        self.next = n + 1;
        // The last mark is exact, in spite of rounding.
        let part = f64::from(n) / f64::from(parts);
        let at = if n == parts { last } else { first + (last - first) * part };
        Some(Mark { at, forward })
    }
}

impl Iterator for Marks {
    type Item = Mark;

    fn next(&mut self) -> Option<Mark> {
        match &mut self.0 {
            Kind::Even(even) => even.next(),
            Kind::Round(round) => round.next(),
        }
    }
}
