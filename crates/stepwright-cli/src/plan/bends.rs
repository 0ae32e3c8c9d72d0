//! The continuous S-curve that a travel is held to, computed independently.
//!
//! Shares nothing with the core but the values as held. A ramp is known by its
//! two speeds: it leads as far as at their mean, in the time
//!
//! ```text
//!   T = Δv/a + a/J          a = min(A, √(J·Δv))
//! ```
//!
//! so the peak speed of a short travel is that whose ramps fill it. Found
//! in `f64`, then mended by Newton's method in 104 bits, as is the time of a
//! pulse; the error against the true value is below 2⁻⁸⁰ of the time.

use super::real::Real;
use stepwright::{Accel, Jerk, Rate, Speed};

/// A travel as the core holds it.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    /// Of the step timer.
    pub rate: Rate,
    /// Speed at both ends.
    pub start: Speed,
    /// Top speed.
    pub top: Speed,
    /// Acceleration.
    pub accel: Accel,
    /// Deceleration.
    pub decel: Accel,
    /// Of both.
    pub jerk: Jerk,
    /// Pulses.
    pub pulses: u32,
}

/// A change of speed that begins and ends without acceleration, in thousandths
/// of a step and seconds.
#[derive(Clone, Copy, Debug)]
struct Ramp {
    from: Real,
    to: Real,
    jerk: Real,
    /// The largest acceleration, and how long it grows.
    accel: Real,
    bend: Real,
    time: Real,
    way: Real,
}

fn half(x: Real) -> Real {
    x / Real::from(2u32)
}

impl Ramp {
    fn new(from: Real, to: Real, most: Real, jerk: Real) -> Ramp {
        let gain = to - from;
        if gain <= Real::ZERO {
            let none = Real::ZERO;
            return Ramp { from, to: from, jerk, accel: none, bend: none, time: none, way: none };
        }
        let steep = (jerk * gain).sqrt();
        let accel = if steep < most { steep } else { most };
        let bend = accel / jerk;
        let time = gain / accel + bend;
        Ramp { from, to, jerk, accel, bend, time, way: half((from + to) * time) }
    }

    /// Way and speed at a time.
    fn at(&self, t: Real) -> (Real, Real) {
        let sixth = |t: Real| self.jerk * t * t * t / Real::from(6u32);
        let left = self.time - t;
        if t <= self.bend {
            (self.from * t + sixth(t), self.from + half(self.jerk * t * t))
        } else if left <= self.bend {
            (self.way - (self.to * left - sixth(left)), self.to - half(self.jerk * left * left))
        } else {
            let (begin, t) = (self.from + half(self.accel * self.bend), t - self.bend);
            let bend = self.from * self.bend + sixth(self.bend);
            (bend + begin * t + half(self.accel * t * t), begin + self.accel * t)
        }
    }

    /// When it has led so far.
    fn when(&self, way: Real) -> Real {
        if way <= Real::ZERO {
            return Real::ZERO;
        }
        let [from, to, jerk, accel, bend, time, all, target] =
            [self.from, self.to, self.jerk, self.accel, self.bend, self.time, self.way, way]
                .map(Real::to_f64);
        // The same as `at`, in f64, halved until nothing changes any more.
        let short = |t: f64| {
            let left = time - t;
            let way = if t <= bend {
                t * (from + jerk * t * t / 6.0)
            } else if left <= bend {
                all - left * (to - jerk * left * left / 6.0)
            } else {
                let (begin, u) = (from + accel * bend / 2.0, t - bend);
                bend * (from + jerk * bend * bend / 6.0) + u * (begin + accel * u / 2.0)
            };
            way < target
        };
        let (mut low, mut high) = (0.0, time);
        loop {
            let middle = (low + high) / 2.0;
            if middle <= low || middle >= high {
                break;
            }
            *(if short(middle) { &mut low } else { &mut high }) = middle;
        }
        let mut t = Real::from(high);
        for _ in 0..2 {
            let (at, v) = self.at(t);
            t = t - (at - way) / v;
        }
        t
    }
}

/// An S-curve as real numbers.
#[derive(Clone, Copy, Debug)]
pub struct Bends {
    rise: Ramp,
    fall: Ramp,
    /// Highest speed, in 0.001 steps/s.
    peak: Real,
    /// In thousandths of a step.
    length: Real,
    /// Ticks per second.
    ticks: Real,
}

impl Bends {
    /// The ideal of an order.
    pub fn new(order: &Order) -> Bends {
        let start = Real::from(order.start.min(order.top).millisteps());
        let top = Real::from(order.top.millisteps());
        let (accel, decel) = (order.accel.millisteps(), order.decel.millisteps());
        let (accel, decel) = (Real::from(accel), Real::from(decel));
        let jerk = Real::from(order.jerk.millisteps());
        let length = Real::from(1000 * u64::from(order.pulses.saturating_sub(1)));
        let ramps =
            |peak| (Ramp::new(start, peak, accel, jerk), Ramp::new(start, peak, decel, jerk));
        let way = |peak| {
            let (rise, fall) = ramps(peak);
            rise.way + fall.way
        };
        let mut peak = top;
        if way(top) > length {
            let (mut low, mut high) = (start.to_f64(), top.to_f64());
            loop {
                let middle = (low + high) / 2.0;
                if middle <= low || middle >= high {
                    break;
                }
                let short = way(Real::from(middle)) < length;
                *(if short { &mut low } else { &mut high }) = middle;
            }
            // By secants of a small width: each round mends 20 bits or more.
            peak = Real::from(high);
            for _ in 0..3 {
                let beside = peak + (peak - start) / Real::from(1u64 << 24);
                let slope = (way(beside) - way(peak)) / (beside - peak);
                if slope > Real::ZERO {
                    peak = peak - (way(peak) - length) / slope;
                }
            }
        }
        let (rise, fall) = ramps(peak);
        Bends { rise, fall, peak, length, ticks: Real::from(order.rate.hz()) }
    }

    /// Ticks from the first pulse to pulse `n`, counted from 0.
    pub fn time(&self, n: u32) -> Real {
        let at = Real::from(1000 * u64::from(n));
        let left = self.length - at;
        let cruise = |to: Real| (to - self.rise.way) / self.peak;
        let seconds = if at < self.rise.way {
            self.rise.when(at)
        } else if left >= self.fall.way {
            self.rise.time + cruise(at)
        } else {
            let level = cruise(self.length - self.fall.way);
            self.rise.time + level + (self.fall.time - self.fall.when(left))
        };
        seconds * self.ticks
    }

    /// The highest speed in steps/s.
    pub fn peak(&self) -> f64 {
        self.peak.to_f64() / 1000.0
    }
}
