//! What an axis may do within its limits, in floating point and from first principles.
//!
//! Nothing here plans. These are bounds that every motion with a bounded
//! acceleration keeps, whoever planned it:
//!
//! ```text
//!   mean speeds of neighbouring intervals   v₂ − v₁ ≤ a · (Δ₁ + Δ₂) / 2
//!   the first interval of a travel          v ≤ vs + a · Δ / 2
//!   the way to rest                         s ≤ v·lag + (v² − vs²) / 2d + v·tj
//! ```
//!
//! where `lag` is the time for which a board has planned ahead, and `tj` what a limit
//! of jerk adds.

/// What begins within this time may be planned already, in s: the horizon.
pub const HORIZON: f64 = 0.016;
/// A run that begins within the horizon lasts for no longer than this, in s, or is a step.
pub const RUN: f64 = 0.008;
/// The foreground of a board has a look this often, in s, at least: so long what was said may wait.
pub const VISIT: f64 = 0.001;
/// A travel that waits for nothing makes its first step within this time, in s.
const START: f64 = 0.030;

/// The limits of a travel, in steps and seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Start/stop speed; not above `top`.
    pub start: f64,
    /// Top speed.
    pub top: f64,
    /// Acceleration; infinite where top and start speed leave nothing to ramp.
    pub up: f64,
    /// Deceleration, likewise.
    pub down: f64,
    /// Jerk; infinite without a limit.
    pub jerk: f64,
}

/// How far and how long an axis may go on until it rests.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Steps.
    pub steps: f64,
    /// Seconds.
    pub time: f64,
}

impl Limits {
    /// Those of an order, its top speed in 0.001 steps/s: accelerations of 0 stand for ramps of `ramp` steps.
    pub fn new(start: u32, top: u32, ramp: u32, up: u32, down: u32, jerk: u32) -> Limits {
        let (vs, vt) = (f64::from(start), f64::from(top) / 1000.0);
        let vs = vs.min(vt);
        let counted =
            if vt > vs { (vt * vt - vs * vs) / 2.0 / f64::from(ramp) } else { f64::INFINITY };
        let slope = |own: u32| if own == 0 { counted } else { f64::from(own) };
        let jerk = if jerk == 0 { f64::INFINITY } else { f64::from(jerk) };
        Limits { start: vs, top: vt, up: slope(up), down: slope(down), jerk }
    }

    /// The time of the first step from rest, in s: at most.
    pub fn first(&self) -> f64 {
        from_rest(self.start, self.up, self.jerk).max(1.0 / self.top)
    }

    /// The time of the last step before rest, in s: at most.
    pub fn last(&self) -> f64 {
        from_rest(self.start, self.down, self.jerk).max(1.0 / self.top)
    }

    /// How long a motor rests between two travels, in s: one interval of its start speed.
    pub fn rest(&self) -> f64 {
        if self.start > 0.0 { 1.0 / self.start } else { (2.0 / self.up).sqrt().max(1.0 / self.top) }
    }

    /// What the limit of jerk adds to a change of speed, in s.
    pub fn bend(&self, v: f64) -> f64 {
        let bend = |a: f64| (a / self.jerk).min((v / self.jerk).sqrt());
        if self.jerk.is_finite() { 2.0 * (bend(self.up) + bend(self.down)) } else { 0.0 }
    }

    /// The speed at the end of an interval of the mean speed `v`, at most: that of constant
    /// acceleration, which from rest is twice the mean, or with a limit of jerk three times.
    pub fn end_speed(&self, v: f64) -> f64 {
        let most = if self.jerk.is_finite() { 3.0 } else { 2.0 };
        (v + self.up / 2.0 / v.max(1e-9)).min(most * v).min(self.top.max(v))
    }

    /// The way to rest of an axis that is told so now, and learns of it at the next visit, `v` being its speed at the end of its
    /// last interval, with what is planned in front of it: all that begins within the horizon, and
    /// the present step and the next. That step was made `since` seconds ago, and the next one was
    /// not: so the axis is faster by now, by `up` for that time and over a step at most. `first`
    /// is how long a first or last step may take.
    pub fn way(&self, v: f64, since: f64, first: f64) -> Way {
        // Its last interval may have been a rest, before a leg that begins with its start speed.
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

    /// The way to rest of an axis that obeys, `v` being the speed of its last interval and that
    /// at its end; of none if it has just made its first step. The last interval may have been
    /// made by other limits, so what it ended with is not for these to say.
    pub fn way_from(&self, v: Option<(f64, f64)>, first: f64) -> Way {
        let fast = v.map_or(self.start, |(_, end)| end.max(self.start));
        let bend = self.bend(self.top.max(fast));
        let fast = (fast + self.up * bend).min(self.top.max(fast));
        let (steps, time) = self.fall(fast);
        // A part of a step at its speed is in front of the fall, which ends on a step.
        Way {
            steps: fast * bend + steps + 2.0,
            time: bend
                + time
                + 2.0 / v.map_or(f64::INFINITY, |(v, _)| v)
                + 3.0 * first.max(self.last()),
        }
    }

    /// Steps and seconds from a speed to the start speed.
    fn fall(&self, v: f64) -> (f64, f64) {
        if v <= self.start || self.down.is_infinite() {
            return (0.0, 0.0);
        }
        let steps = (v * v - self.start * self.start) / 2.0 / self.down;
        (steps * 1.001, (v - self.start) / self.down * 1.05)
    }

    /// Seconds after which a travel of this many steps has ended, at most.
    pub fn duration(&self, steps: f64) -> f64 {
        let ramp = |a: f64| if a.is_finite() { (self.top - self.start) / a } else { 0.0 };
        // A travel too short for its top speed takes no longer than one with it.
        let ramps = ramp(self.up) + ramp(self.down);
        let peaks = 2.0 * (steps / self.up).sqrt() + 2.0 * (steps / self.down).sqrt();
        let cruise = steps / self.top + ramps;
        let slow = steps / self.start.max(1e-9);
        cruise.max(peaks).min(slow.max(steps / self.top)) * 1.01
            + self.bend(self.top) * 2.0
            + 2.0 * (self.first() + self.last())
            + START
    }

    /// Whether the ramps may take more steps than a board counts: 2³¹ where nothing else
    /// bounds them, 2²² with a limit of jerk; within a factor of four.
    pub fn is_gentle(&self, endless: bool) -> bool {
        let slope = self.up.min(self.down);
        if self.jerk.is_finite() {
            let steps =
                (self.top * self.top / 2.0 / slope).max(self.top * (self.top / self.jerk).sqrt());
            return steps > f64::from(1 << 20);
        }
        endless && self.top * self.top / 2.0 / slope > f64::from(1 << 29)
    }

    /// The highest speed of a travel of this many steps, in steps/s: at least.
    pub fn peak(&self, steps: f64) -> f64 {
        let room = (steps - 1.0).max(0.0);
        if room == 0.0 {
            // One step has no speed.
            return 0.0;
        }
        if self.jerk.is_finite() {
            // Bends take some of it, how much is not known here.
            return self.start;
        }
        if !self.up.is_finite() || !self.down.is_finite() || room.is_infinite() {
            return self.top;
        }
        let squared =
            self.start * self.start + 2.0 * self.up * self.down * room / (self.up + self.down);
        squared.sqrt().min(self.top)
    }

    /// The loosest of two sets of limits, for a time in which either holds.
    pub fn or(&self, other: &Limits) -> Limits {
        Limits {
            start: self.start.max(other.start),
            top: self.top.max(other.top),
            up: self.up.max(other.up),
            down: self.down.max(other.down),
            jerk: self.jerk.max(other.jerk),
        }
    }

    /// The slowest: those that end last.
    pub fn slower(&self, other: &Limits) -> Limits {
        let (top, up) = (self.top.min(other.top), self.up.min(other.up));
        Limits { top, up, ..self.lazier(other) }
    }

    /// The laziest: those that stop last.
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

/// The time of one step from rest, with any of the limits: the least of what each
/// would take, plus what the jerk adds.
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
        // Of a first step the next one ends the way.
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
