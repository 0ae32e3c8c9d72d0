//! Bounds on the motion of an axis within its limits, in floating point and from first principles.
//!
//! Nothing here plans. Every motion with a bounded acceleration keeps these bounds, by any planner:
//!
//! ```text
//!   mean speeds of neighbouring intervals   v₂ − v₁ ≤ a · (Δ₁ + Δ₂) / 2
//!   the first interval of a travel          v ≤ vs + a · Δ / 2
//!   the way to rest                         s ≤ v·lag + (v² − vs²) / 2d + v·tj
//! ```
//!
//! `lag` is the time for which a board has planned ahead, and `tj` the time that a limit of jerk adds.

/// Motion that begins within this time, in s, may be planned already: the horizon.
pub const HORIZON: f64 = 0.016;
/// The longest run that begins within the horizon, in s, unless it is a single step.
pub const RUN: f64 = 0.008;
/// The foreground of a board looks at new orders at least this often, in s. An order may wait for this
/// time.
pub const VISIT: f64 = 0.001;
/// A travel that waits for nothing makes its first step within this time in s.
const START: f64 = 0.030;

/// The limits of a travel, in steps and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Start/stop speed, at most `top`.
    pub start: f64,
    /// Top speed.
    pub top: f64,
    /// Acceleration; infinite if top and start speed leave nothing to ramp.
    pub up: f64,
    /// Deceleration; infinite as `up`.
    pub down: f64,
    /// Jerk; infinite without a limit.
    pub jerk: f64,
}

/// The most steps and the longest time until an axis rests.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Steps.
    pub steps: f64,
    /// Seconds.
    pub time: f64,
}

impl Limits {
    /// The limits of an order, its top speed in 0.001 steps/s. An acceleration of 0 means a ramp of `ramp`
    /// steps.
    pub fn new(start: u32, top: u32, ramp: u32, up: u32, down: u32, jerk: u32) -> Limits {
        let (vs, vt) = (f64::from(start), f64::from(top) / 1000.0);
        let vs = vs.min(vt);
        let counted =
            if vt > vs { (vt * vt - vs * vs) / 2.0 / f64::from(ramp) } else { f64::INFINITY };
        let slope = |own: u32| if own == 0 { counted } else { f64::from(own) };
        let jerk = if jerk == 0 { f64::INFINITY } else { f64::from(jerk) };
        Limits { start: vs, top: vt, up: slope(up), down: slope(down), jerk }
    }

    /// The longest time of the first step from rest, in s.
    pub fn first(&self) -> f64 {
        from_rest(self.start, self.up, self.jerk).max(1.0 / self.top)
    }

    /// The longest time of the last step before rest, in s.
    pub fn last(&self) -> f64 {
        from_rest(self.start, self.down, self.jerk).max(1.0 / self.top)
    }

    /// The rest between two travels in s: one interval of the start speed.
    pub fn rest(&self) -> f64 {
        if self.start > 0.0 { 1.0 / self.start } else { (2.0 / self.up).sqrt().max(1.0 / self.top) }
    }

    /// The time that the limit of jerk adds to a change of speed, in s.
    pub fn bend(&self, v: f64) -> f64 {
        let bend = |a: f64| (a / self.jerk).min((v / self.jerk).sqrt());
        if self.jerk.is_finite() { 2.0 * (bend(self.up) + bend(self.down)) } else { 0.0 }
    }

    /// The highest speed at the end of an interval with the mean speed `v`: that of constant acceleration.
    /// From rest it is twice the mean, or three times with a limit of jerk.
    pub fn end_speed(&self, v: f64) -> f64 {
        let most = if self.jerk.is_finite() { 3.0 } else { 2.0 };
        (v + self.up / 2.0 / v.max(1e-9)).min(most * v).min(self.top.max(v))
    }

    /// The way to rest of an axis that gets the order now and learns of it at the next visit. `v` is its
    /// speed at the end of its last interval. The way includes what is planned already: all that begins within
    /// the horizon, the present step and the next. The last step was `since` seconds ago, and the next has not
    /// come: so the axis may be faster by `up` for that time, over at most a step. `first` is the longest time
    /// of a first or last step.
    pub fn way(&self, v: f64, since: f64, first: f64) -> Way {
        // The last interval may have been a rest before a leg that begins with the start speed.
        let v = v.max(self.start);
        let (ahead, bend) = (VISIT + HORIZON + RUN, self.bend(self.top.max(v)));
        let present = (v + self.up * since).min((v * v + 2.0 * self.up).sqrt());
        let timed = present + self.up * (ahead + bend);
        let counted = (v * v + 4.0 * self.up).sqrt() + self.up * bend;
        let fastest = timed.max(counted).min(self.top.max(v));
        let (steps, time) = self.fall(fastest);
        let slow = 3.0 / v.max(1e-9) + 2.0 * first;
        Way {
            steps: fastest * (ahead + bend) + steps + 5.0,
            time: ahead + bend + time + slow + 3.0 * first.max(self.last()),
        }
    }

    /// The way to rest of an axis that obeys. `v` is the speed of its last interval and the speed at its
    /// end; `None` after its first step. The last interval may have had other limits, so these limits do not
    /// give its end speed.
    pub fn way_from(&self, v: Option<(f64, f64)>, first: f64) -> Way {
        let fast = v.map_or(self.start, |(_, end)| end.max(self.start));
        let bend = self.bend(self.top.max(fast));
        let fast = (fast + self.up * bend).min(self.top.max(fast));
        let (steps, time) = self.fall(fast);
        // Before the fall comes a part of a step at this speed. The fall ends on a step.
        Way {
            steps: fast * bend + steps + 2.0,
            time: bend
                + time
                + 2.0 / v.map_or(f64::INFINITY, |(v, _)| v)
                + 3.0 * first.max(self.last()),
        }
    }

    /// Steps and seconds of a fall from a speed to the start speed.
    fn fall(&self, v: f64) -> (f64, f64) {
        if v <= self.start || self.down.is_infinite() {
            return (0.0, 0.0);
        }
        let steps = (v * v - self.start * self.start) / 2.0 / self.down;
        (steps * 1.001, (v - self.start) / self.down * 1.05)
    }

    /// The most seconds until a travel of this many steps has ended.
    pub fn duration(&self, steps: f64) -> f64 {
        let ramp = |a: f64| if a.is_finite() { (self.top - self.start) / a } else { 0.0 };
        // A travel too short for its top speed takes no longer than a travel that reaches it.
        let ramps = ramp(self.up) + ramp(self.down);
        let peaks = 2.0 * (steps / self.up).sqrt() + 2.0 * (steps / self.down).sqrt();
        let cruise = steps / self.top + ramps;
        let slow = steps / self.start.max(1e-9);
        cruise.max(peaks).min(slow.max(steps / self.top)) * 1.01
            + self.bend(self.top) * 2.0
            + 2.0 * (self.first() + self.last())
            + START
    }

    /// Whether the ramps may take more steps than a board counts: 2³¹ if nothing else bounds them, 2²² with
    /// a limit of jerk; within a factor of four.
    pub fn is_gentle(&self, endless: bool) -> bool {
        let slope = self.up.min(self.down);
        if self.jerk.is_finite() {
            let steps =
                (self.top * self.top / 2.0 / slope).max(self.top * (self.top / self.jerk).sqrt());
            return steps > f64::from(1 << 20);
        }
        endless && self.top * self.top / 2.0 / slope > f64::from(1 << 29)
    }

    /// The least peak speed of a travel of this many steps, in steps/s.
    pub fn peak(&self, steps: f64) -> f64 {
        let room = (steps - 1.0).max(0.0);
        if room == 0.0 {
            // One step has no speed.
            return 0.0;
        }
        if self.jerk.is_finite() {
            // Bends take some of the steps; their number is not known here.
            return self.start;
        }
        if !self.up.is_finite() || !self.down.is_finite() || room.is_infinite() {
            return self.top;
        }
        let squared =
            self.start * self.start + 2.0 * self.up * self.down * room / (self.up + self.down);
        squared.sqrt().min(self.top)
    }

    /// The loosest limits of two sets, for a time in which either may hold.
    pub fn or(&self, other: &Limits) -> Limits {
        Limits {
            start: self.start.max(other.start),
            top: self.top.max(other.top),
            up: self.up.max(other.up),
            down: self.down.max(other.down),
            jerk: self.jerk.max(other.jerk),
        }
    }

    /// The limits with the lower speed and acceleration, which end last.
    pub fn slower(&self, other: &Limits) -> Limits {
        let (top, up) = (self.top.min(other.top), self.up.min(other.up));
        Limits { top, up, ..self.lazier(other) }
    }

    /// The limits with the longest way to rest.
    pub fn lazier(&self, other: &Limits) -> Limits {
        Limits {
            start: self.start.min(other.start),
            top: self.top.max(other.top),
            up: self.up.max(other.up),
            down: self.down.min(other.down),
            jerk: self.jerk.min(other.jerk),
        }
    }
}

/// The time of one step from rest with any of the limits: the shortest by slope or start speed, plus the
/// time that the jerk adds.
fn from_rest(start: f64, slope: f64, jerk: f64) -> f64 {
    if slope.is_infinite() {
        return 1.0 / start;
    }
    let by_slope = (2.0 / slope).sqrt() + (6.0 / jerk).cbrt();
    by_slope.min(1.0 / start)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_acceleration_is_just_within() {
        // From 100 steps/s at 1000 steps/s²: the time of step n in closed form.
        let limits = Limits::new(100, 5_000_000, 1, 1000, 1000, 0);
        let time = |n: f64| ((1e4 + 2e3 * n).sqrt() - 100.0) / 1e3;
        assert!(time(1.0) <= limits.first());
        for n in 1..50 {
            let (t0, t1, t2) =
                (time(f64::from(n) - 1.0), time(f64::from(n)), time(f64::from(n) + 1.0));
            let (d1, d2) = (t1 - t0, t2 - t1);
            assert!(1.0 / d2 - 1.0 / d1 <= 1000.0 * (d1 + d2) / 2.0 + 1e-6);
        }
        assert!((limits.peak(2402.0) - 1552.76).abs() < 0.1);
        let end = limits.end_speed(1000.0);
        assert!(end > 1000.4 && end < 1000.6);
        let (learns, obeys) =
            (limits.way(end, 0.0, 0.0).steps, limits.way_from(Some((1000.0, end)), 0.0));
        assert!(obeys.steps > 495.0 && obeys.steps < 500.0, "{obeys:?}");
        assert!(learns > obeys.steps + 24.0 && learns < 560.0, "{learns}");
        // After a first step, the next step ends the way.
        assert!(limits.way_from(None, 0.0).steps < 3.0);
    }

    #[test]
    fn ramps_in_steps_become_slopes() {
        let limits = Limits::new(50, 1_000_000, 200, 0, 4000, 0);
        assert!((limits.up - 2493.75).abs() < 1e-9 && limits.down == 4000.0);
        assert!(Limits::new(1000, 50_000, 200, 0, 0, 0).up.is_infinite());
        assert_eq!(Limits::new(1000, 50_000, 200, 0, 0, 0).start, 50.0);
    }
}
