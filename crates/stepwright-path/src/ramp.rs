//! Ramps with limited jerk from one speed to another, without acceleration at either end.
//!
//! ```text
//!   a    ╱▔▔╲            a change of speed by d takes     2·√(d/J)      up to d = A²/J
//!       ╱    ╲                                            d/A + A/J     beyond
//!   v  _╱▔▔▔▔▔           and leads, by symmetry, (v₀ + v₁)/2 times that far
//! ```

use crate::course::{Push, join};
use crate::pace::Pace;
use crate::piece::{Moment, Piece};

/// The limits along a part of a route, in its unit and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Limits {
    pub accel: f64,
    pub jerk: f64,
}

impl Limits {
    /// These limits as those of a path.
    pub fn pace(&self) -> Pace {
        Pace::new(1.0, self.accel).with_jerk(self.jerk)
    }

    /// The same limits, with at least this acceleration, which the motion has already.
    pub fn with(self, accel: f64) -> Limits {
        Limits { accel: self.accel.max(accel.abs()), ..self }
    }

    /// The time of a change of speed, in s.
    pub fn time(&self, change: f64) -> f64 {
        let change = change.abs();
        if change * self.jerk <= self.accel * self.accel {
            2.0 * (change / self.jerk).sqrt()
        } else {
            change / self.accel + self.accel / self.jerk
        }
    }

    /// The distance of a change of speed.
    pub fn way(&self, from: f64, to: f64) -> f64 {
        (from + to) / 2.0 * self.time(to - from)
    }

    /// The speed that can be reached from `from` over a distance; also the speed from which `from` can be
    /// reached.
    pub fn rise(&self, from: f64, way: f64) -> f64 {
        // The speed without a limit of jerk.
        let most = (from * from + 2.0 * self.accel * way).sqrt();
        root(from, most, |v| self.way(from, v) - way)
    }

    /// The pushes that change the speed.
    fn pushes(&self, from: f64, to: f64) -> [Push; 3] {
        let change = (to - from).abs();
        let sign = if to < from { -1.0 } else { 1.0 };
        let peak = (self.jerk * change).sqrt().min(self.accel);
        let hold = if peak < self.accel { 0.0 } else { change / peak - peak / self.jerk };
        let bend = peak / self.jerk;
        [(sign * self.jerk, bend), (0.0, hold.max(0.0)), (-sign * self.jerk, bend)]
    }
}

/// The limits on the way up to the highest speed, and on the way down from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sides {
    pub up: Limits,
    pub down: Limits,
}

impl Sides {
    /// The same limits on both sides.
    pub fn both(limits: Limits) -> Sides {
        Sides { up: limits, down: limits }
    }

    /// The smaller limits of both sides.
    pub fn least(&self) -> Limits {
        let Sides { up, down } = *self;
        Limits { accel: up.accel.min(down.accel), jerk: up.jerk.min(down.jerk) }
    }

    /// Returns the fastest pieces from one moment to another, at most at the speed `top`. The first moment may
    /// have an acceleration upwards, the second one an acceleration downwards. `None` if the distance is too
    /// short, or `top` too low, for these accelerations.
    pub fn over(&self, from: Moment, to: Moment, top: f64) -> Option<Vec<Piece>> {
        let Sides { up, down } = *self;
        let ends = [(from.v, from.a, up.jerk), (to.v, -to.a, down.jerk)];
        // Both ends are extended to moments without acceleration.
        let [begin, end] = ends.map(|(v, a, jerk)| v - a * a / 2.0 / jerk);
        let before = ends.map(|(v, a, jerk)| (v - a * a / 3.0 / jerk) * a / jerk);
        let [rise, fall] = ends.map(|(_, a, jerk)| a / jerk);
        let least = ends.map(|(v, a, jerk)| v + a * a / 2.0 / jerk);
        let way = to.s - from.s + before[0] + before[1];
        let low = least[0].max(least[1]);
        let both = |peak: f64| up.way(begin, peak) + down.way(peak, end);
        let bent = rise > 0.0 || fall > 0.0;
        if bent && (both(low) > way || low > top) {
            return None;
        }
        let top = top.max(low);
        let peak = if both(top) <= way { top } else { root(low, top, |v| both(v) - way) };
        let level = (way - both(peak)).max(0.0) / peak;
        let level = if level.is_finite() { level } else { 0.0 };
        let mut up = up.pushes(begin, peak);
        let mut down = down.pushes(peak, end);
        up[0].1 = (up[0].1 - rise).max(0.0);
        down[2].1 = (down[2].1 - fall).max(0.0);
        let mut pieces = join(from, &up, peak);
        let mut begin = pieces.last().map_or(from, |piece| piece.to);
        if level > 0.0 {
            let end = Moment { t: begin.t + level, s: begin.s + level * peak, v: peak, a: 0.0 };
            pieces.push(Piece { from: begin, to: end, jerk: 0.0 });
            begin = end;
        }
        pieces.extend(join(begin, &down, to.v));
        if let Some(last) = pieces.last_mut() {
            last.to = Moment { t: last.to.t, ..to };
        }
        Some(pieces)
    }
}

/// The place at which a rising function reaches 0, from below; `high` if it does not reach 0.
pub(crate) fn root(low: f64, high: f64, of: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (low, high);
    let (mut below, mut above) = (of(low), of(high));
    if above <= 0.0 {
        return high;
    }
    // By the secant; every third time by halves, as the secant may move one end only.
    for n in 0..200 {
        let middle = low + (high - low) / 2.0;
        let chord = low - below * (high - low) / (above - below);
        let next = if n % 3 == 2 || !(chord > low && chord < high) { middle } else { chord };
        if next <= low || next >= high || high - low <= 1e-15 * high {
            break;
        }
        let off = of(next);
        if off <= 0.0 {
            (low, below) = (next, off);
        } else {
            (high, above) = (next, off);
        }
        if off.abs() == 0.0 {
            break;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { accel: 1_000.0, jerk: 10_000.0 };

    #[test]
    fn ramps_by_hand() {
        // 0 to 100: A²/J is 100, so 0.2 s at a mean of 50.
        assert!((LIMITS.way(0.0, 100.0) - 10.0).abs() < 1e-12);
        // 0 to 300: 0.4 s.
        assert!((LIMITS.way(300.0, 0.0) - 60.0).abs() < 1e-12);
        assert!((LIMITS.rise(0.0, 60.0) - 300.0).abs() < 1e-9);
        // 5 to 30 in 0.1 s.
        assert!((LIMITS.rise(5.0, 1.75) - 30.0).abs() < 1e-9);
    }

    #[test]
    fn a_course_begins_and_ends_where_it_should() {
        for (v, to, way) in [(0.0, 0.0, 1.0), (5.0, 5.0, 10.0), (80.0, 0.0, 30.0), (3.0, 60.0, 9.0)]
        {
            let from = Moment { t: 1.0, s: 2.0, v, a: 0.0 };
            let end = Moment { t: 0.0, s: 2.0 + way, v: to, a: 0.0 };
            let pieces = Sides::both(LIMITS).over(from, end, 100.0).unwrap();
            let mut at = from;
            for piece in &pieces {
                assert!((piece.from.s - at.s).abs() < 1e-12 && (piece.from.v - at.v).abs() < 1e-12);
                assert!((piece.from.a - at.a).abs() < 1e-9 && piece.from.t == at.t);
                let end = piece.from.after(piece.jerk, piece.to.t - piece.from.t);
                assert!((end.s - piece.to.s).abs() < 1e-9 && (end.v - piece.to.v).abs() < 1e-8);
                assert!(end.a.abs() <= 1_000.000_001 && end.v <= 100.000_001);
                at = piece.to;
            }
            assert_eq!((at.s, at.v, at.a), (2.0 + way, to, 0.0));
        }
    }

    #[test]
    fn each_side_has_its_limits() {
        let down = Limits { accel: 500.0, jerk: 5_000.0 };
        let sides = Sides { up: LIMITS, down };
        // 0 to 100 in 0.2 s over 10, and to 0 again in 0.3 s over 15.
        let way = LIMITS.way(0.0, 100.0) + down.way(100.0, 0.0);
        assert!((way - 25.0).abs() < 1e-12);
        let (from, to) = (Moment::at_rest(0.0, 0.0), Moment::at_rest(0.0, 25.0));
        let pieces = sides.over(from, to, 1e9).unwrap();
        let peak = pieces.iter().map(|piece| piece.to.v).fold(0.0, f64::max);
        assert!((peak - 100.0).abs() < 1e-9, "{peak}");
        assert!((pieces.last().unwrap().to.t - 0.5).abs() < 1e-9);
        let steep = pieces.iter().map(|piece| piece.to.a);
        assert!((steep.fold(0.0, f64::min) + 500.0).abs() < 1e-9);
    }

    #[test]
    fn a_course_begins_and_ends_with_its_acceleration() {
        let from = Moment { t: 1.0, s: 2.0, v: 5.0, a: 300.0 };
        for (way, top) in [(10.0, 100.0), (10.0, 30.0), (2.0, 100.0), (200.0, 300.0)] {
            let end = Moment { t: 0.0, s: 2.0 + way, v: 8.0, a: -200.0 };
            let pieces = Sides::both(LIMITS).over(from, end, top).unwrap();
            let mut at = from;
            for piece in &pieces {
                assert!((piece.from.v - at.v).abs() < 1e-9 && (piece.from.a - at.a).abs() < 1e-9);
                let to = piece.from.after(piece.jerk, piece.to.t - piece.from.t);
                assert!((to.s - piece.to.s).abs() < 1e-9 && (to.v - piece.to.v).abs() < 1e-8);
                assert!((to.a - piece.to.a).abs() < 1e-8 && to.v <= top + 1e-6, "{to:?}");
                at = piece.to;
            }
            assert_eq!((at.s, at.v, at.a), (2.0 + way, 8.0, -200.0));
        }
        // Ending the accelerations of 300 and -200 takes speeds of 9.5 and 10 at least.
        let end = Moment { t: 0.0, s: 2.3, v: 8.0, a: -200.0 };
        assert!(Sides::both(LIMITS).over(from, end, 100.0).is_none());
        let end = Moment { t: 0.0, s: 4.0, v: 8.0, a: -200.0 };
        assert!(Sides::both(LIMITS).over(from, end, 9.0).is_none());
    }
}
