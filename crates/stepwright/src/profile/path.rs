//! A path: up to three pieces of constant acceleration, in closed form.
//!
//! Over the steps, constant acceleration makes the speed squared a straight line, so corners are
//! divisions and everything else is additions:
//!
//! ```text
//!   w = v²     rise        level          fall
//!   w_peak        ┌──────────────────────┐
//!                ╱│                      │╲        w(n) = w_begin ± a2·n
//!   w_begin     ╱ │                      │ ╲       w(n) = w_end + d2·(length − n)
//!   w_end                                   ╲
//!              0  accel_end                 decel_start length   → n (steps)
//! ```
//!
//! with a2 = 2a and d2 = 2d. The time of pulse n follows from the speed alone,
//!
//! ```text
//!   rise   t(n) = (v(n) − v_begin) / a
//!   level  t(n) = t(accel_end) + (n − accel_end) / v_peak
//!   fall   t(n) = t(length) − (v(n) − v_end) / d
//! ```
//!
//! (Austin, Eq 1–8, with a start speed; the Nano slave's ramp). The error of [`Path::time_of`]
//! against the ideal, for the stored values, is at most half a tick, or 2⁻⁴⁰ of the time.

use super::Unfit;
use crate::fixed::{self, ONE, Q32, Scale, portion, ratio, root, root_fine};
use crate::units::{Accel, Rate, Speed};

/// The piece of a path to which a step belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Towards the top speed (downwards, if the path begins above it).
    Up,
    /// At constant speed.
    Cruise,
    /// Towards the end speed.
    Down,
    /// In an S-curve: the magnitude of the acceleration grows.
    JerkUp,
    /// In an S-curve: the magnitude of the acceleration falls.
    JerkDown,
}

impl Phase {
    /// `up`, `cruise`, `down`, `jerk-up` or `jerk-down`.
    pub const fn name(self) -> &'static str {
        match self {
            Phase::Up => "up",
            Phase::Cruise => "cruise",
            Phase::Down => "down",
            Phase::JerkUp => "jerk-up",
            Phase::JerkDown => "jerk-down",
        }
    }
}

/// The limits of a path: speeds, and accelerations as slopes of w.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bounds {
    /// The timer's rate.
    pub rate: Rate,
    /// Start and stop speed.
    pub start: Speed,
    /// Top speed.
    pub top: Speed,
    /// 2a in 10⁻⁶ (steps/s)² per step, not 0.
    pub a2: u64,
    /// 2d in 10⁻⁶ (steps/s)² per step, not 0.
    pub d2: u64,
}

/// The slope of speed² at an acceleration: 2a in 10⁻⁶ (steps/s)² per step.
pub const fn slope_of(a: Accel) -> u64 {
    a.millisteps() * 2000
}

/// A motion along one axis in closed form: three pieces of constant acceleration, with one pulse
/// per step.
///
/// Made by a law ([`Trapezoid::path`](super::Trapezoid::path),
/// [`RampSteps::path`](super::RampSteps::path)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Path {
    pub(crate) rate: Rate,
    /// Pulses: one more than the steps between the first and the last.
    pulses: u32,
    pub(crate) w_begin: u64,
    pub(crate) w_end: u64,
    pub(crate) w_peak: u64,
    pub(crate) v_peak: u64,
    /// Slopes; the first piece falls if `sinks`.
    pub(crate) a2: u64,
    pub(crate) d2: u64,
    pub(crate) sinks: bool,
    /// The end of the first and the beginning of the last piece.
    pub(crate) accel_end: Q32,
    pub(crate) decel_start: Q32,
    pub(crate) rise: Scale,
    pub(crate) fall: Scale,
    /// The interval at the top speed.
    pub(crate) level: Q32,
}

/// A `decel_start` that never comes: an endless run.
const NEVER: Q32 = u64::MAX;

impl Path {
    /// From rest to rest: `pulses` pulses that begin and end at the start speed. If the top speed
    /// is not above the start speed there is no ramp: all at the top speed.
    pub(crate) fn new(bounds: &Bounds, pulses: u32) -> Result<Path, Unfit> {
        if pulses > 1 << 31 {
            return Err(Unfit::TooLong);
        }
        bounds.check()?;
        let start = bounds.start.min(bounds.top).squared();
        Ok(Path::from_motion(bounds, start, pulses))
    }

    /// From a motion at speed² `w` to rest, `pulses` − 1 steps further: the pulse at 0 has been
    /// made. The steps must be enough to brake.
    pub(crate) fn from_motion(bounds: &Bounds, w: u64, pulses: u32) -> Path {
        let Bounds { rate, start, top, a2, d2 } = *bounds;
        let length = u64::from(pulses.saturating_sub(1)) << 32;
        let (w_top, w_end) = (top.squared(), start.min(top).squared().min(w));
        let sinks = w > w_top;
        let slope = if sinks { d2 } else { a2 };
        let accel_end = ratio(w.abs_diff(w_top), slope);
        let brake = ratio(w_top - w_end.min(w_top), d2);
        let mut path = Path {
            rate,
            pulses,
            w_begin: w,
            w_end,
            w_peak: w_top,
            v_peak: root(w_top),
            a2: slope,
            d2,
            sinks,
            accel_end,
            decel_start: length.saturating_sub(brake),
            rise: Scale::new(rate, slope),
            fall: Scale::new(rate, d2),
            level: fixed::interval(rate, top),
        };
        if accel_end.saturating_add(brake) > length {
            path.turn_early(length);
        }
        path
    }

    /// Endless: from speed² `w` to the top speed, without an end.
    pub(crate) fn endless(bounds: &Bounds, w: u64) -> Path {
        let mut path = Path::from_motion(bounds, w, u32::MAX);
        let top = bounds.top.squared();
        path.accel_end = ratio(w.abs_diff(top), path.a2);
        (path.w_peak, path.v_peak, path.decel_start) = (top, root(top), NEVER);
        path
    }

    /// Sets the peak if the top speed is out of reach: the rise meets the fall at s = (d2·L −
    /// (w_begin − w_end)) / (a2 + d2) (Austin, Eq 19).
    ///
    /// Computed from the flatter side: its product fits in 64 bits, and a rounded position disturbs
    /// its speed less.
    fn turn_early(&mut self, length: Q32) {
        let steps = length >> 32;
        let above = self.w_begin - self.w_end.min(self.w_begin);
        if self.sinks {
            // Only the braking curve is left: it begins at once.
            (self.accel_end, self.w_peak, self.v_peak) = (0, self.w_begin, root(self.w_begin));
        } else if self.a2 <= self.d2 {
            let fall = ratio(self.a2.wrapping_mul(steps).wrapping_add(above), self.a2 + self.d2);
            self.accel_end = length.saturating_sub(fall);
            (self.w_peak, self.v_peak) = along(self.w_begin, self.a2, self.accel_end);
        } else {
            let reach = self.d2.wrapping_mul(steps).saturating_sub(above);
            self.accel_end = ratio(reach, self.a2 + self.d2);
            let left = length.saturating_sub(self.accel_end);
            (self.w_peak, self.v_peak) = along(self.w_end, self.d2, left);
        }
        self.decel_start = self.accel_end;
    }

    /// Pulses in this path, 0 … 2³¹; `u32::MAX` if it is endless.
    pub const fn pulses(&self) -> u32 {
        self.pulses
    }

    /// Whether the path has no end.
    pub const fn is_endless(&self) -> bool {
        self.decel_start == NEVER
    }

    /// Steps from the first pulse to the last.
    pub(crate) const fn length(&self) -> u32 {
        self.pulses.saturating_sub(1)
    }

    /// w at pulse n: exact on the ramps.
    pub(crate) fn w_at(&self, n: u32) -> u64 {
        let at = u64::from(n) << 32;
        if at < self.accel_end {
            let change = self.a2.wrapping_mul(n.into());
            if self.sinks {
                self.w_begin.saturating_sub(change)
            } else {
                self.w_begin.wrapping_add(change)
            }
        } else if at < self.decel_start {
            self.w_peak
        } else {
            let left = self.length().saturating_sub(n);
            self.w_end.wrapping_add(self.d2.wrapping_mul(left.into()))
        }
    }

    /// The highest speed on this path, in thousandths of a step per second,
    /// rounded up.
    pub fn peak(&self) -> u32 {
        let w = if self.pulses < 2 { 0 } else { self.w_peak.max(self.w_begin) };
        (root(w).saturating_add((1 << 33) - 1) >> 33) as u32
    }

    /// The phase of pulse n: that of the middle of the interval before it; for pulse 0, that of the
    /// first interval.
    pub fn phase_of(&self, n: u32) -> Phase {
        let middle = (u64::from(n.max(1)) << 32) - ONE / 2;
        if middle < self.accel_end {
            Phase::Up
        } else if middle < self.decel_start || self.is_endless() {
            Phase::Cruise
        } else {
            Phase::Down
        }
    }

    /// The steps of the fall, rounded up; 0 for an endless path.
    pub fn braking_steps(&self) -> u32 {
        let length = u64::from(self.length()) << 32;
        (length.saturating_sub(self.decel_start).saturating_add(ONE - 1) >> 32) as u32
    }

    /// The stored 2a of the rise and 2d of the fall, in 10⁻⁶ (steps/s)² per step.
    pub const fn slopes(&self) -> (u64, u64) {
        (self.a2, self.d2)
    }

    /// The positions at which the rise ends and the fall begins.
    pub(crate) fn corner(&self) -> (Q32, Q32) {
        (self.accel_end, self.decel_start)
    }

    /// The time of pulse `n`, in ticks after pulse 0, rounded to the nearest tick; `n` beyond the
    /// end counts as the end. Works in 128 bits: for hosts.
    pub fn time_of(&self, n: u32) -> u64 {
        let n = if self.is_endless() { n } else { n.min(self.length()) };
        let at = u64::from(n) << 32;
        let (accel_end, decel_start) = self.corner();
        let v_begin = root(self.w_begin);
        let mut time = self.rise.long_time(v_begin.abs_diff(if at < accel_end {
            root(self.w_at(n))
        } else {
            self.v_peak
        }));
        if at > accel_end {
            let level = u128::from(at.min(decel_start).saturating_sub(accel_end));
            time = time.wrapping_add(level.wrapping_mul(self.level.into()) >> 48);
        }
        if at > decel_start {
            time = time.wrapping_add(self.fall.long_time(self.v_peak.abs_diff(root(self.w_at(n)))));
        }
        u64::try_from((time + 0x8000) >> 16).unwrap_or(u64::MAX)
    }
}

/// w + slope · at for a position in 2⁻³² steps, and its root. Between steps w has a fraction, which
/// the time of the peak needs at low accelerations.
fn along(w: u64, slope: u64, at: Q32) -> (u64, u64) {
    let part = at as u32;
    let w = w.wrapping_add(slope.wrapping_mul(at >> 32)).wrapping_add(portion(slope, part));
    (w, root_fine(w, (slope as u32).wrapping_mul(part)))
}

impl Bounds {
    /// Checks that no interval exceeds 2³¹ ticks, including the one across the peak.
    ///
    /// # Errors
    /// [`Unfit::Standstill`] without a top speed, [`Unfit::TooSlow`] for longer intervals.
    pub fn check(&self) -> Result<(), Unfit> {
        if self.top == Speed::ZERO {
            return Err(Unfit::Standstill);
        }
        let slowest = match self.start.min(self.top) {
            // From rest: the first step takes √(2/a), the last √(2/d).
            Speed::ZERO => {
                let first = |slope| Scale::new(self.rate, slope).time(root(slope));
                let ramps = first(self.a2).saturating_add(first(self.d2));
                ramps.saturating_add(fixed::interval(self.rate, self.top))
            }
            v => fixed::interval(self.rate, v),
        };
        if slowest >> 63 != 0 { Err(Unfit::TooSlow) } else { Ok(()) }
    }
}
