//! Judges of a motion by its steps alone. They share nothing with what plans it.
//!
//! **The law of speed.** For every axis and every two times |v(t) − v(t')| ≤ S + A·|t − t'|. The
//! mean speed between two steps in the same direction is known exactly, and so is its time: the
//! middle of both. Between a step and the same step back it is 0. With these, S is at least
//!
//! ```text
//!   max over t' ≤ t of |v(t) − v(t')| − A·(t − t')
//! ```
//!
//! which one pass finds: all that is kept are the largest v' + A·t' and the least v' − A·t'.

// Each test program uses a part of it.

pub mod jerk;

/// One axis: seconds and direction of its steps.
pub type Axis = Vec<(f64, bool)>;

/// Mean speeds at their times, from rest at 0 to rest at `end`, in units/s.
pub fn speeds(steps: &Axis, size: f64, end: f64) -> Vec<(f64, f64)> {
    let mut speeds = vec![(0.0, 0.0)];
    for pair in steps.windows(2) {
        let [(from, before), (to, after)] = [pair[0], pair[1]];
        let way = if before != after { 0.0 } else { size * if after { 1.0 } else { -1.0 } };
        assert!(to > from, "a step at {to} s, not behind the one at {from} s");
        speeds.push(((from + to) / 2.0, way / (to - from)));
    }
    speeds.push((end, 0.0));
    speeds
}

/// The jump that the steps of an axis need, and when.
pub fn jump_needed(steps: &Axis, size: f64, accel: f64, end: f64) -> (f64, f64) {
    let (mut high, mut low) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut needed = (0.0, 0.0);
    for (t, v) in speeds(steps, size, end) {
        assert!(t.is_finite() && v.is_finite(), "{v} at {t}");
        high = high.max(v + accel * t);
        low = low.min(v - accel * t);
        let jump = (high - accel * t - v).max(v - (low + accel * t));
        if jump > needed.0 {
            needed = (jump, t);
        }
    }
    needed
}
