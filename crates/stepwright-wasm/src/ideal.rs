//! What a travel should be: formulas in `f64`, independent of the core's integers.
//!
//! Constant acceleration, by speeds at places and times by mean speeds:
//!
//! ```text
//!   rise  t = 2s / (v(s) + v_s)        v(s)² = v_s² + 2as
//!   fall  the same, seen from the end
//! ```
//!
//! Limited jerk, by ramps between two speeds: a ramp leads as far as at their mean, in
//!
//! ```text
//!   T = Δv/a + a/J          a = min(A, √(J·Δv))
//! ```
//!
//! A time of 2⁴⁰ ticks has an error of 2⁻¹² of them.

use libm::sqrt;
use stepwright::{Accel, Jerk, Speed};

/// Steps/s.
pub(crate) fn steps_per_second(speed: Speed) -> f64 {
    f64::from(speed.millisteps()) / 1e3
}

/// Steps/s².
pub(crate) fn steps_per_second2(accel: Accel) -> f64 {
    accel.millisteps() as f64 / 1e3
}

/// Constant acceleration, top speed, constant deceleration.
#[derive(Clone, Copy, Debug)]
pub struct ConstantIdeal {
    start: f64,
    peak: f64,
    /// 2a and 2d.
    slopes: (f64, f64),
    /// Steps in all, and where the ramps end and begin.
    length: f64,
    corners: (f64, f64),
    /// Seconds from the first pulse to the last.
    total: f64,
}

impl ConstantIdeal {
    /// `pulses` pulses between `start` and `top`.
    pub fn new(start: Speed, top: Speed, up: Accel, down: Accel, pulses: u32) -> ConstantIdeal {
        let (start, mut peak) = (steps_per_second(start.min(top)), steps_per_second(top));
        let slopes = (2.0 * steps_per_second2(up), 2.0 * steps_per_second2(down));
        let length = f64::from(pulses.saturating_sub(1));
        let gain = peak * peak - start * start;
        let mut corners = (gain / slopes.0, length - gain / slopes.1);
        if corners.0 > corners.1 {
            let meet = length * slopes.1 / (slopes.0 + slopes.1);
            corners = (meet, meet);
            peak = sqrt(start * start + slopes.0 * meet);
        }
        let mut ideal = ConstantIdeal { start, peak, slopes, length, corners, total: 0.0 };
        ideal.total = ideal.ramp(corners.0, slopes.0)
            + ideal.level(corners.1)
            + ideal.ramp(length - corners.1, slopes.1);
        ideal
    }

    /// Seconds from the first pulse to pulse `n`, counted from 0.
    pub fn time(&self, n: u32) -> f64 {
        let at = f64::from(n);
        if at <= self.corners.0 {
            self.ramp(at, self.slopes.0)
        } else if at <= self.corners.1 {
            self.ramp(self.corners.0, self.slopes.0) + self.level(at)
        } else {
            self.total - self.ramp(self.length - at, self.slopes.1)
        }
    }

    /// Seconds in all.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// The highest speed in steps/s.
    pub fn peak(&self) -> f64 {
        self.peak
    }

    fn ramp(&self, way: f64, slope: f64) -> f64 {
        if way <= 0.0 {
            return 0.0;
        }
        2.0 * way / (sqrt(self.start * self.start + slope * way) + self.start)
    }

    fn level(&self, at: f64) -> f64 {
        (at - self.corners.0) / self.peak
    }
}

/// A change of speed that begins and ends without acceleration.
#[derive(Clone, Copy, Debug)]
struct BentRamp {
    from: f64,
    to: f64,
    jerk: f64,
    /// The largest acceleration, and how long it grows.
    accel: f64,
    bend: f64,
    time: f64,
    way: f64,
}

impl BentRamp {
    fn new(from: f64, to: f64, most: f64, jerk: f64) -> BentRamp {
        let gain = to - from;
        if gain <= 0.0 {
            return BentRamp { from, to: from, jerk, accel: 0.0, bend: 0.0, time: 0.0, way: 0.0 };
        }
        let accel = sqrt(jerk * gain).min(most);
        let bend = accel / jerk;
        let time = gain / accel + bend;
        BentRamp { from, to, jerk, accel, bend, time, way: (from + to) / 2.0 * time }
    }

    /// Steps and speed at a time.
    fn at(&self, t: f64) -> (f64, f64) {
        let left = self.time - t;
        if t <= self.bend {
            let gain = self.jerk * t * t;
            (t * (self.from + gain / 6.0), self.from + gain / 2.0)
        } else if left <= self.bend {
            let gain = self.jerk * left * left;
            (self.way - left * (self.to - gain / 6.0), self.to - gain / 2.0)
        } else {
            let (begin, t) = (self.from + self.accel * self.bend / 2.0, t - self.bend);
            let bend = self.bend * (self.from + self.jerk * self.bend * self.bend / 6.0);
            (bend + t * (begin + self.accel * t / 2.0), begin + self.accel * t)
        }
    }

    /// When it has led so far: halved to a thousandth of the ramp, then by Newton's method.
    fn when(&self, way: f64) -> f64 {
        if way <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high) = (0.0, self.time);
        for _ in 0..10 {
            let middle = (low + high) / 2.0;
            *(if self.at(middle).0 < way { &mut low } else { &mut high }) = middle;
        }
        let mut t = (low + high) / 2.0;
        for _ in 0..20 {
            let (at, speed) = self.at(t);
            if speed <= 0.0 {
                break;
            }
            let next = (t - (at - way) / speed).max(low).min(high);
            if next == t {
                break;
            }
            t = next;
        }
        t
    }
}

/// Limited jerk: an S-curve from the start speed and back to it.
#[derive(Clone, Copy, Debug)]
pub struct BentIdeal {
    rise: BentRamp,
    fall: BentRamp,
    peak: f64,
    length: f64,
}

impl BentIdeal {
    /// `pulses` pulses between `start` and `top`.
    pub fn new(
        start: Speed,
        top: Speed,
        (up, down): (Accel, Accel),
        jerk: Jerk,
        pulses: u32,
    ) -> BentIdeal {
        let (start, top) = (steps_per_second(start.min(top)), steps_per_second(top));
        let (up, down) = (steps_per_second2(up), steps_per_second2(down));
        let jerk = jerk.millisteps() as f64 / 1e3;
        let length = f64::from(pulses.saturating_sub(1));
        let ramps =
            |peak| (BentRamp::new(start, peak, up, jerk), BentRamp::new(start, peak, down, jerk));
        let short = |peak| {
            let (rise, fall) = ramps(peak);
            rise.way + fall.way < length
        };
        let mut peak = top;
        if !short(top) {
            let (mut low, mut high) = (start, top);
            for _ in 0..80 {
                let middle = (low + high) / 2.0;
                *(if short(middle) { &mut low } else { &mut high }) = middle;
            }
            peak = high;
        }
        let (rise, fall) = ramps(peak);
        BentIdeal { rise, fall, peak, length }
    }

    /// Seconds from the first pulse to pulse `n`, counted from 0.
    pub fn time(&self, n: u32) -> f64 {
        let at = f64::from(n);
        let left = self.length - at;
        let level = |to: f64| ((to - self.rise.way) / self.peak).max(0.0);
        if at < self.rise.way {
            self.rise.when(at)
        } else if left >= self.fall.way {
            self.rise.time + level(at)
        } else {
            self.total() - self.fall.when(left)
        }
    }

    /// Seconds in all.
    pub fn total(&self) -> f64 {
        let level = (self.length - self.fall.way - self.rise.way) / self.peak;
        self.rise.time + level.max(0.0) + self.fall.time
    }

    /// The highest speed in steps/s.
    pub fn peak(&self) -> f64 {
        self.peak
    }
}
