//! The continuous profile that a travel is held to, computed independently.
//!
//! Shares nothing with the core but the values as held: corners are solved for
//! as positions, times follow from distance over mean speed,
//!
//! ```text
//!   rise  t = 2s / (v(s) + v_s)        v(s)² = v_s² + 2as
//!   fall  the same, seen from the end
//! ```
//!
//! in 104 bits. The error against the true value is below 2⁻⁹⁰ of the time.

use super::real::Real;
use stepwright::{Rate, Speed};

/// Constant acceleration, top speed, constant deceleration, as real numbers.
#[derive(Clone, Copy, Debug)]
pub struct Ideal {
    /// v_s² in 10⁻⁶ (steps/s)², and v_s in 0.001 steps/s.
    start_squared: Real,
    start: Real,
    /// Slopes of v² per step: 2a and 2d in 10⁻⁶ (steps/s)².
    slopes: (Real, Real),
    /// Highest speed in 0.001 steps/s.
    peak: Real,
    /// Steps in all, and where the ramps end and begin.
    length: Real,
    corners: (Real, Real),
    /// Ticks per second · 1000: a step at 0.001 steps/s.
    ticks: Real,
    /// From the first pulse to the last.
    total: Real,
}

impl Ideal {
    /// `pulses` pulses; `slopes` are 2a and 2d in 10⁻⁶ (steps/s)² per step.
    pub fn new(rate: Rate, start: Speed, top: Speed, slopes: (u64, u64), pulses: u32) -> Ideal {
        let speed = |v: Speed| Real::from(v.millisteps());
        let (start, mut peak) = (speed(start.min(top)), speed(top));
        let slopes = (Real::from(slopes.0), Real::from(slopes.1));
        let length = Real::from(pulses.saturating_sub(1));
        let gain = peak * peak - start * start;
        let mut corners = (gain / slopes.0, length - gain / slopes.1);
        if corners.0 > corners.1 {
            let meet = length * slopes.1 / (slopes.0 + slopes.1);
            corners = (meet, meet);
            peak = (start * start + slopes.0 * meet).sqrt();
        }
        let ticks = Real::from(1000 * u64::from(rate.hz()));
        let mut ideal = Ideal {
            start_squared: start * start,
            start,
            slopes,
            peak,
            length,
            corners,
            ticks,
            total: Real::ZERO,
        };
        ideal.total = ideal.ramp(corners.0, slopes.0)
            + ideal.level(corners.1)
            + ideal.ramp(length - corners.1, slopes.1);
        ideal
    }

    /// Ticks from the first pulse to pulse `n`, counted from 0.
    pub fn time(&self, n: u32) -> Real {
        let at = Real::from(n);
        if at <= self.corners.0 {
            self.ramp(at, self.slopes.0)
        } else if at <= self.corners.1 {
            self.ramp(self.corners.0, self.slopes.0) + self.level(at)
        } else {
            self.total - self.ramp(self.length - at, self.slopes.1)
        }
    }

    /// The highest speed in steps/s.
    pub fn peak(&self) -> f64 {
        self.peak.to_f64() / 1000.0
    }

    /// Ticks for the first `way` steps of a ramp.
    fn ramp(&self, way: Real, slope: Real) -> Real {
        if way <= Real::ZERO {
            return Real::ZERO;
        }
        let v = (self.start_squared + slope * way).sqrt();
        (way + way) * self.ticks / (v + self.start)
    }

    /// Ticks from the end of the rise to `at`.
    fn level(&self, at: Real) -> Real {
        (at - self.corners.0) * self.ticks / self.peak
    }
}
