//! The times of the pulses of an ordered travel, under a trapezoid or an S-curve.

use stepwright::profile::{Curve, Path, Phase};
use stepwright::{Rate, Travel};

/// The timer of the computed durations. The board's own may differ; the difference is too small to see.
const CLOCK: Rate = Rate::MHZ;

/// A travel that ends, in closed form.
pub enum Course {
    /// Under a trapezoid.
    Trapezoid(Path),
    /// Under an S-curve.
    Curve(Box<Curve>),
}

impl Course {
    /// The course of an order; `None` if it is endless, or its times do not fit into the timer.
    pub fn of(order: &stepwright::Order) -> Option<Course> {
        let Travel::By(steps) = order.travel else { return None };
        match order.s_curve(CLOCK) {
            None => order.path(CLOCK).ok().map(Course::Trapezoid),
            Some(law) => {
                law.ok()?.curve(steps.unsigned_abs()).ok().map(|c| Course::Curve(Box::new(c)))
            }
        }
    }

    /// The number of pulses.
    pub fn pulses(&self) -> u32 {
        match self {
            Course::Trapezoid(path) => path.pulses(),
            Course::Curve(curve) => curve.pulses(),
        }
    }

    /// The highest speed, in 0.001 steps/s.
    pub fn peak(&self) -> u32 {
        match self {
            Course::Trapezoid(path) => path.peak(),
            Course::Curve(curve) => curve.peak(),
        }
    }

    /// Seconds from the first pulse to pulse `n`, counted from 0.
    pub fn seconds(&self, n: u32) -> f64 {
        let ticks = match self {
            Course::Trapezoid(path) => path.time_of(n),
            Course::Curve(curve) => curve.time_of(n),
        };
        ticks as f64 / f64::from(CLOCK.hz())
    }

    /// Seconds from the first pulse to the last.
    pub fn duration(&self) -> f64 {
        self.seconds(self.pulses().saturating_sub(1))
    }

    /// Seconds from the first pulse to where a stop would make the travel end in the same place.
    pub fn brakes(&self) -> f64 {
        let braking = match self {
            Course::Trapezoid(path) => path.braking_steps(),
            Course::Curve(curve) => match cut_short(curve) {
                Some(pulses) => return self.seconds(pulses),
                None => curve.braking_steps(),
            },
        };
        self.seconds(self.pulses().saturating_sub(1).saturating_sub(braking))
    }
}

/// The number of pulses after which a curve without a cruise begins to ease its acceleration.
fn cut_short(curve: &Curve) -> Option<u32> {
    let mut phases = curve.phases();
    if curve.phases().any(|(phase, _)| phase == Phase::Cruise) {
        return None;
    }
    let mut gone = 0;
    phases.find_map(|(phase, pulses)| {
        let eases = phase == Phase::JerkDown;
        gone += if eases { 0 } else { pulses };
        eases.then_some(gone)
    })
}
