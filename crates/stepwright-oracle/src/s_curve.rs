//! A travel with a limited jerk.
//!
//! A ramp is determined by its two speeds: its distance is that at their mean, in the time
//!
//! ```text
//!   T = Δv/a + a/J          a = min(A, √(J·Δv))          dT/dv = 1/a
//! ```
//!
//! so a short travel gains the speed whose ramps fill it. That speed, and the time of a place, are
//! computed in `f64` and refined by Newton's method for numbers with more bits. With
//! [`Double`](crate::Double) the error against the true value is below 2⁻⁷⁶ of the time.

use crate::Number;

/// The most iterations of bisection and Newton's method in `f64`; some ten are needed, or 60 with
/// bisection.
const TRIES: u32 = 200;

/// The limits of a travel, in consistent units: steps, steps/s, steps/s² and steps/s³ give seconds.
#[derive(Clone, Copy, Debug)]
pub struct JerkLimits<N> {
    /// The speed at both ends; above `top` it becomes `top`.
    pub start: N,
    /// Top speed.
    pub top: N,
    /// Acceleration.
    pub accel: N,
    /// Deceleration.
    pub decel: N,
    /// The change of both per second.
    pub jerk: N,
}

impl<N: Number> JerkLimits<N> {
    /// The ramps for this gain of speed, up and down.
    fn ramps(&self, gain: N) -> (Ramp<N>, Ramp<N>) {
        let JerkLimits { start, accel, decel, jerk, .. } = *self;
        (Ramp::new(start, gain, accel, jerk), Ramp::new(start, gain, decel, jerk))
    }

    fn to_f64(self) -> JerkLimits<f64> {
        let JerkLimits { start, top, accel, decel, jerk } = self;
        let [start, top, accel, decel, jerk] = [start, top, accel, decel, jerk].map(N::to_f64);
        JerkLimits { start, top, accel, decel, jerk }
    }

    /// The gain of speed whose ramps are as long as a travel that is too short for the top speed.
    /// The gain is computed, not the speed, because it may be less than a bit of the speed.
    fn gain(&self, length: N) -> N {
        let (rough, far) = (self.to_f64(), length.to_f64());
        let (mut low, mut high) = (0.0, rough.top - rough.start);
        for _ in 0..TRIES {
            let middle = (low + high) / 2.0;
            if middle <= low || middle >= high {
                break;
            }
            let (rise, fall) = rough.ramps(middle);
            *(if rise.way + fall.way < far { &mut low } else { &mut high }) = middle;
        }
        let mut gain = N::from_f64(high);
        for _ in 0..N::ROUNDS {
            let (rise, fall) = self.ramps(gain);
            let slope = rise.growth() + fall.growth();
            if slope > N::whole(0) {
                gain = gain - (rise.way + fall.way - length) / slope;
            }
        }
        gain
    }
}

/// A change of speed that begins and ends without acceleration.
#[derive(Clone, Copy, Debug)]
struct Ramp<N> {
    from: N,
    to: N,
    jerk: N,
    /// The largest acceleration, and how long it grows.
    accel: N,
    bend: N,
    time: N,
    way: N,
}

fn half<N: Number>(x: N) -> N {
    x / N::whole(2)
}

impl<N: Number> Ramp<N> {
    fn new(from: N, gain: N, most: N, jerk: N) -> Ramp<N> {
        let (to, none) = (from + gain, N::whole(0));
        if gain <= none {
            return Ramp { from, to: from, jerk, accel: none, bend: none, time: none, way: none };
        }
        let steep = (jerk * gain).root();
        let accel = if steep < most { steep } else { most };
        let bend = accel / jerk;
        let time = gain / accel + bend;
        Ramp { from, to, jerk, accel, bend, time, way: half((from + to) * time) }
    }

    /// The growth of the ramp's length with its final speed.
    fn growth(&self) -> N {
        if self.accel > N::whole(0) {
            half(self.time + (self.from + self.to) / self.accel)
        } else {
            N::whole(0)
        }
    }

    /// Distance and speed at a time.
    fn at(&self, t: N) -> (N, N) {
        let sixth = |t: N| self.jerk * t * t * t / N::whole(6);
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

    /// The time at a distance.
    fn when(&self, way: N) -> N {
        if way <= N::whole(0) {
            return N::whole(0);
        }
        let Ramp { from, to, jerk, accel, bend, time, way: all } = *self;
        let [from, to, jerk, accel, bend, time, all] =
            [from, to, jerk, accel, bend, time, all].map(N::to_f64);
        let rough = Ramp { from, to, jerk, accel, bend, time, way: all };
        let mut t = N::from_f64(rough.found(way.to_f64()));
        for _ in 0..N::ROUNDS {
            let (at, v) = self.at(t);
            t = t - (at - way) / v;
        }
        t
    }
}

impl Ramp<f64> {
    /// The time at a distance by Newton's method, with bisection where that diverges.
    fn found(&self, way: f64) -> f64 {
        let (mut low, mut high, mut t) = (0.0, self.time, self.time / 2.0);
        for _ in 0..TRIES {
            let (at, v) = self.at(t);
            *(if at < way { &mut low } else { &mut high }) = t;
            let newton = t - (at - way) / v;
            let next = if low < newton && newton < high { newton } else { (low + high) / 2.0 };
            if next == t {
                break;
            }
            t = next;
        }
        t
    }
}

/// The fastest travel within limits of speed, acceleration and jerk.
#[derive(Clone, Copy, Debug)]
pub struct IdealSCurve<N> {
    rise: Ramp<N>,
    fall: Ramp<N>,
    peak: N,
    length: N,
}

impl<N: Number> IdealSCurve<N> {
    /// A travel of this length.
    pub fn new(limits: JerkLimits<N>, length: N) -> IdealSCurve<N> {
        let JerkLimits { start, top, .. } = limits;
        let limits = JerkLimits { start: if start < top { start } else { top }, ..limits };
        let mut gain = top - limits.start;
        let (mut rise, mut fall) = limits.ramps(gain);
        if rise.way + fall.way > length {
            gain = limits.gain(length);
            (rise, fall) = limits.ramps(gain);
        }
        let peak = limits.start + gain;
        IdealSCurve { rise, fall, peak, length }
    }

    /// The time from the beginning to a place.
    pub fn time(&self, at: N) -> N {
        let left = self.length - at;
        if at < self.rise.way {
            self.rise.when(at)
        } else if left >= self.fall.way {
            self.rise.time + self.level(at)
        } else {
            self.total() - self.fall.when(left)
        }
    }

    /// The total time.
    pub fn total(&self) -> N {
        self.rise.time + self.level(self.length - self.fall.way) + self.fall.time
    }

    /// The highest speed.
    pub fn peak(&self) -> N {
        self.peak
    }

    /// The time from the end of the rise to a place on the level.
    fn level(&self, at: N) -> N {
        let way = at - self.rise.way;
        if way > N::whole(0) { way / self.peak } else { N::whole(0) }
    }
}
