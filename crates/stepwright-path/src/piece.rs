//! A piece of the motion, with constant jerk.
//!
//! A time τ after its beginning, or before its end:
//!
//! ```text
//!   s = s₀ + v₀·τ + a₀·τ²/2 + j·τ³/6
//!   s = s₁ − v₁·τ + a₁·τ²/2 − j·τ³/6
//! ```
//!
//! The time at which it passes a place is computed from its slower end, where nothing large is subtracted.
//! Without jerk, in closed form:
//!
//! ```text
//!   τ = 2σ / (v + √(v² + 2aσ))
//! ```
//!
//! With jerk, by Newton's method between two bounds. The error of a time is some 2⁻⁵⁰ of the longest time in
//! it.

/// The time, the place, the speed and the acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Moment {
    pub t: f64,
    pub s: f64,
    pub v: f64,
    pub a: f64,
}

impl Moment {
    pub fn at_rest(t: f64, s: f64) -> Moment {
        Moment { t, s, v: 0.0, a: 0.0 }
    }

    /// The moment `time` later, at a constant jerk.
    pub fn after(self, jerk: f64, time: f64) -> Moment {
        let Moment { t, s, v, a } = self;
        Moment {
            t: t + time,
            s: s + way(v, a, jerk, time),
            v: v + (a + jerk * time / 2.0) * time,
            a: a + jerk * time,
        }
    }
}

/// v·t + a·t²/2 + j·t³/6.
fn way(v: f64, a: f64, j: f64, t: f64) -> f64 {
    (v + (a + j * t / 3.0) * t / 2.0) * t
}

/// The motion from one moment to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    pub from: Moment,
    pub to: Moment,
    pub jerk: f64,
}

impl Piece {
    /// A rest at `s`.
    pub fn still(s: f64, from: f64, to: f64) -> Piece {
        Piece { from: Moment::at_rest(from, s), to: Moment::at_rest(to, s), jerk: 0.0 }
    }

    pub fn at(&self, t: f64) -> Moment {
        if t >= self.to.t { self.to } else { self.from.after(self.jerk, t - self.from.t) }
    }

    /// The part of the piece up to `t`.
    pub fn until(self, t: f64) -> Piece {
        Piece { to: self.at(t), ..self }
    }

    /// The time at which it passes `s`.
    pub fn time(&self, s: f64) -> f64 {
        let Piece { from, to, jerk } = *self;
        let most = to.t - from.t;
        if to.v < from.v {
            to.t - tau(to.s - s, to.v, -to.a, jerk, most)
        } else {
            from.t + tau(s - from.s, from.v, from.a, jerk, most)
        }
    }
}

/// The relative change of a time below which it is rounding: the last digit of 1.
const ROUNDED: f64 = f64::EPSILON;

/// The time over the distance `sigma`, at most `most`.
fn tau(sigma: f64, v: f64, a: f64, j: f64, most: f64) -> f64 {
    if sigma <= 0.0 {
        return 0.0;
    }
    if j == 0.0 {
        return (2.0 * sigma / (v + (v * v + 2.0 * a * sigma).max(0.0).sqrt())).min(most);
    }
    let (mut low, mut high) = (0.0f64, most);
    // Each term alone would take longer than all of them, if none is negative.
    let mut x = most;
    if v > 0.0 && a >= 0.0 && j > 0.0 {
        x = x.min(sigma / v);
    }
    if a > 0.0 && j > 0.0 {
        x = x.min((2.0 * sigma / a).sqrt());
    }
    if a >= 0.0 && j > 0.0 {
        x = x.min((6.0 * sigma / j).cbrt());
    }
    for _ in 0..80 {
        let off = way(v, a, j, x) - sigma;
        if off > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let speed = v + (a + j * x / 2.0) * x;
        let next = x - off / speed;
        if (next - x).abs() <= x * ROUNDED {
            break;
        }
        // Outside the bounds, the interval is halved.
        x = if next > low && next < high { next } else { low + (high - low) / 2.0 };
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The place at the time of a place is that place.
    #[test]
    fn times_and_places_are_each_others_inverse() {
        for (v, a, j) in [
            (0.0, 0.0, 6.0),
            (3.0, -1.0, 0.5),
            (0.0, 2.0, 0.0),
            (5.0, 0.0, 0.0),
            (9.0, 0.0, -2.0),
            (1e-9, 0.0, 3.0),
        ] {
            let from = Moment { t: 1.0, s: 10.0, v, a };
            let piece = Piece { from, to: from.after(j, 2.0), jerk: j };
            for n in 0..=100 {
                let t = 1.0 + f64::from(n) / 50.0;
                let s = piece.at(t).s;
                let back = piece.at(piece.time(s)).s;
                assert!((back - s).abs() < 1e-13 * s, "{v} {a} {j}: {back}, not {s}");
            }
        }
    }
}
