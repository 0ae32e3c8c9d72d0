//! Judges of a motion that use only its steps. They share no code with the planner.
//!
//! **The law of speed.** For each axis and any two times |v(t) − v(t')| ≤ S + A·|t − t'|. The mean speed
//! between two steps in the same direction is known exactly, and so is its time, the middle between both.
//! Between a step and the same step back it is 0. With these speeds, S is at least
//!
//! ```text
//!   max over t' ≤ t of |v(t) − v(t')| − A·(t − t')
//! ```
//!
//! One pass finds this: it keeps only the largest v' + A·t' and the smallest v' − A·t'.
//!
//! In a long interval the mean says little about the speed at its ends. Within an interval an axis stays within
//! one step, and within another quarter where a turn was not worth a step. Its mean speed over a time h after
//! the first step, and over h before the second, is therefore 0, with an error of at most 1.25 steps / h; with
//! h = √(step/A) that error is smallest.

pub mod jerk;

/// A mean speed of an axis.
#[derive(Clone, Copy, Debug)]
pub struct Mean {
    /// The middle of its time, and the length of that time; 0 at rest.
    pub time: f64,
    pub wide: f64,
    /// The speed in units/s, with an error of at most `off`.
    pub speed: f64,
    pub off: f64,
}

/// The distance that an axis may move without a step, in steps.
const WITHIN: f64 = 1.25;

/// The mean speeds of an axis by its steps, from rest at 0 to rest at `end`.
pub fn means(steps: &Axis, size: f64, accel: f64, end: f64) -> Vec<Mean> {
    let known = speeds(steps, size, end);
    let wide = (size / accel).sqrt();
    let mut means = Vec::with_capacity(known.len() + 16);
    let mut from = 0.0;
    let ends = steps.iter().map(|step| step.0).chain([end]);
    for (n, to) in ends.enumerate() {
        let near = |time: f64| Mean { time, wide, speed: 0.0, off: WITHIN * size / wide };
        let long = to - from > 2.0 * wide;
        if n == 0 {
            means.push(Mean { time: 0.0, wide: 0.0, speed: 0.0, off: 0.0 });
        }
        if long {
            means.push(near(from + wide / 2.0));
        }
        if let Some((time, speed)) = known.get(n).filter(|_| n > 0 && n < steps.len()) {
            means.push(Mean { time: *time, wide: to - from, speed: *speed, off: 0.0 });
        }
        if long {
            means.push(near(to - wide / 2.0));
        }
        from = to;
    }
    means.push(Mean { time: end, wide: 0.0, speed: 0.0, off: 0.0 });
    means
}

/// The steps of one axis: their times in s, and their directions.
pub type Axis = Vec<(f64, bool)>;

/// The mean speeds with their times, from rest at 0 to rest at `end`, in units/s.
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

/// The jump that the steps of an axis need, and its time.
pub fn jump_needed(steps: &Axis, size: f64, accel: f64, end: f64) -> (f64, f64) {
    let (mut high, mut low) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut needed = (0.0, 0.0);
    for Mean { time: t, speed: v, off, .. } in means(steps, size, accel, end) {
        assert!(t.is_finite() && v.is_finite(), "{v} at {t}");
        high = high.max(v - off + accel * t);
        low = low.min(v + off - accel * t);
        let jump = (high - accel * t - v - off).max(v - off - (low + accel * t));
        if jump > needed.0 {
            needed = (jump, t);
        }
    }
    needed
}
