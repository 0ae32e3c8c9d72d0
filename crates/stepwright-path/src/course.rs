//! The pieces from a speed and an acceleration to rest at a place.
//!
//! **Trapezoid.** From v below the top speed, the rise and the fall meet at
//!
//! ```text
//!   peak² = (2·a·d·L + d·v²) / (a + d)        or the top speed, if that is less
//! ```
//!
//! From v above the top speed, the speed falls to the top speed first.
//!
//! **S-curve.** As in the core's `profile::s_curve`, whose documentation has the proof: change towards the top
//! speed for a time x, then stop. The distance never falls as x grows, so x is found by bisection. To change
//! the speed by g more than the a²/2J that the present acceleration gains anyway, the acceleration rises to
//!
//! ```text
//!   peak² = J·g + max(a, 0)²                  held at the limit for the rest
//! ```
//!
//! A path is never followed backwards, so no piece reverses. What rounding loses is added where the speed is
//! highest: both ends are exact.

use crate::pace::Pace;
use crate::piece::{Moment, Piece};

/// Returns the pieces from `from` to rest at `end`, at most at the speed `top`. If a stop leads beyond `end`,
/// it returns the stop.
pub(crate) fn go(from: Moment, end: f64, top: f64, pace: &Pace) -> Vec<Piece> {
    if pace.jerk.is_finite() {
        lead(from, (end, 0.0), top, pace)
    } else {
        trapezoid(from, end, top, pace)
    }
}

/// Returns the pieces of the fastest stop from `from`.
pub(crate) fn stop(from: Moment, pace: &Pace) -> Vec<Piece> {
    if pace.jerk.is_finite() {
        return join(from, &reach(from, 0.0, pace), 0.0);
    }
    let (v, d) = (from.v, pace.decel);
    let to = Moment::at_rest(from.t + v / d, from.s + v * v / 2.0 / d);
    vec![Piece { from: Moment { a: -d, ..from }, to: Moment { a: -d, ..to }, jerk: 0.0 }]
}

fn trapezoid(from: Moment, end: f64, top: f64, pace: &Pace) -> Vec<Piece> {
    let Pace { accel, decel, .. } = *pace;
    let Moment { t, s, v, .. } = from;
    let way = (end - s).max(0.0);
    let (peak, slope) = if v > top {
        (top, -decel)
    } else {
        let meet = (2.0 * way * accel * decel + v * v * decel) / (accel + decel);
        (meet.max(0.0).sqrt().min(top).max(v), accel)
    };
    let first = (peak * peak - v * v) / 2.0 / slope;
    let down = peak * peak / 2.0 / decel;
    let level = (way - first - down).max(0.0);
    let t1 = t + (peak - v) / slope;
    let t2 = t1 + level / peak;
    let ends = [
        Moment { t, s, v, a: slope },
        Moment { t: t1, s: (s + first).min(end), v: peak, a: 0.0 },
        Moment { t: t2, s: (end - down).max(s), v: peak, a: -decel },
        Moment { t: t2 + peak / decel, s: end, v: 0.0, a: 0.0 },
    ];
    let piece = |n: usize| {
        let to = Moment { a: ends[n].a, ..ends[n + 1] };
        Piece { from: ends[n], to, jerk: 0.0 }
    };
    (0..3).map(piece).filter(|piece| piece.to.t > piece.from.t).collect()
}

/// A jerk and its time, in s.
pub(crate) type Push = (f64, f64);

/// The pushes to the speed `to`, without acceleration at the end.
pub(crate) fn reach(from: Moment, to: f64, pace: &Pace) -> [Push; 3] {
    let Pace { accel, decel, jerk, .. } = *pace;
    let gain = to - (from.v + from.a * from.a.abs() / 2.0 / jerk);
    let (sign, most) = if gain < 0.0 { (-1.0, decel) } else { (1.0, accel) };
    let (gain, a) = (gain.abs(), from.a * sign);
    let present = a.max(0.0).powi(2);
    let (mut peak, mut hold) = ((jerk * gain + present).sqrt(), 0.0);
    if peak > most {
        hold = ((gain - (most * most - present) / jerk) / most).min(gain / most);
        peak = most;
    }
    let first = if peak < a { -jerk } else { jerk };
    [(sign * first, (peak - a).abs() / jerk), (0.0, hold.max(0.0)), (-sign * jerk, peak / jerk)]
}

/// The moment after these pushes.
fn after(from: Moment, pushes: &[Push]) -> Moment {
    pushes.iter().fold(from, |at, &(jerk, time)| at.after(jerk, time))
}

/// The place at which a change to this speed ends.
pub(crate) fn reached(from: Moment, to: f64, pace: &Pace) -> f64 {
    after(from, &reach(from, to, pace)).s
}

/// The pieces of these pushes, one after the other. The last ends at the speed `to`, without acceleration.
pub(crate) fn join(from: Moment, pushes: &[Push], to: f64) -> Vec<Piece> {
    let mut at = from;
    let mut pieces: Vec<Piece> = Vec::new();
    for &(jerk, time) in pushes.iter().filter(|push| push.1 > 0.0) {
        let to = at.after(jerk, time);
        pieces.push(Piece { from: at, to, jerk });
        at = to;
    }
    if let Some(last) = pieces.last_mut() {
        // Exact, in spite of rounding.
        last.to.v = to;
        last.to.a = 0.0;
    }
    pieces
}

/// Returns the pieces from `from` to the speed `to` at the place `end`. If the change of speed alone leads
/// further, it returns that change.
pub(crate) fn lead(from: Moment, (end, to): (f64, f64), top: f64, pace: &Pace) -> Vec<Piece> {
    let mut pushes = Vec::new();
    let mut at = from;
    let mut short = reached(at, to, pace) < end;
    if short {
        for (jerk, time) in reach(from, top, pace) {
            let there = at.after(jerk, time);
            if reached(there, to, pace) < end {
                pushes.push((jerk, time));
                at = there;
                continue;
            }
            let (mut low, mut high) = (0.0, time);
            for _ in 0..100 {
                let x = low + (high - low) / 2.0;
                if reached(at.after(jerk, x), to, pace) < end {
                    low = x;
                } else {
                    high = x;
                }
            }
            pushes.push((jerk, low));
            at = at.after(jerk, low);
            short = false;
            break;
        }
        if short {
            let level = (end - reached(at, to, pace)) / top;
            pushes.push((0.0, level));
            at = at.after(0.0, level);
        }
    }
    pushes.extend(reach(at, to, pace));
    let mut pieces = join(from, &pushes, to);
    let Some(last) = pieces.last() else { return pieces };
    // The remaining distance is covered at the highest speed.
    let rest = end - last.to.s;
    let speeds = pieces.iter().map(|piece| piece.from.v);
    let (fastest, v) =
        speeds.enumerate().fold((0, 0.0), |best, (n, v)| if v > best.1 { (n, v) } else { best });
    let later = if v > 0.0 { rest / v } else { 0.0 };
    for piece in pieces.iter_mut().skip(fastest) {
        for moment in [&mut piece.from, &mut piece.to] {
            moment.s += rest;
            moment.t += later;
        }
    }
    if let Some(last) = pieces.last_mut() {
        last.to.s = end;
    }
    pieces
}
