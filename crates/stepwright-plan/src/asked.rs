//! What every law with an acceleration and a top speed is asked for.

use stepwright::{Accel, Rate, Speed};
use stepwright_austin::C0;
use stepwright_units::Rounded;

use crate::equations::Counter;
use crate::law::PlanValue;

/// A travel and its limits, as the core holds them.
#[derive(Clone, Debug)]
pub struct PlanLimits {
    /// Of the step timer.
    pub rate: Rate,
    /// Pulses.
    pub steps: u32,
    /// Acceleration.
    pub accel: Rounded<Accel>,
    /// Deceleration; the same unless it was given.
    pub decel: Rounded<Accel>,
    /// Top speed.
    pub top: Rounded<Speed>,
}

impl PlanLimits {
    /// For the summary.
    pub fn values(&self) -> Vec<PlanValue> {
        vec![
            PlanValue::speed("top speed", &self.top),
            PlanValue::accel("acceleration", &self.accel),
            PlanValue::accel("deceleration", &self.decel),
        ]
    }

    /// The timer and a motor whose angles are steps, for Austin's equations.
    pub fn motor(&self) -> Counter {
        Counter { hz: self.rate.hz().into(), step: 1.0 }
    }

    /// Top speed in steps/s.
    pub fn speed(&self) -> f64 {
        f64::from(self.top.value.millisteps()) / 1e3
    }

    /// Acceleration and deceleration in steps/s². An acceleration with which the
    /// very first step would be too fast to brake from is lowered, as the core
    /// does: to that which leaves J = m − ½ in Eq 18.
    pub fn accels(&self) -> (f64, f64) {
        let held = |a: &Rounded<Accel>| a.value.millisteps() as f64 / 1e3;
        let (accel, decel) = (held(&self.accel), held(&self.decel));
        (accel.min((2.0 * f64::from(self.steps.max(1)) - 1.0) * decel), decel)
    }
}

/// How one of Austin's ramps begins: its first delay, which Eq 12 makes too much of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum First {
    /// By Eq 7, as it is: all delays are too long, the acceleration is 0.457 of the one given
    Exact,
    /// 0.676 of it (Eq 15), as the article recommends
    #[cfg_attr(feature = "clap", value(name = "0.676"))]
    Reduced,
    /// By Eq 7, and the second delay 0.4056 of it
    C1,
}

impl First {
    /// As the core has it.
    pub fn core(self) -> C0 {
        match self {
            First::Exact => C0::Exact,
            First::Reduced => C0::Reduced,
            First::C1 => C0::FirstStep,
        }
    }

    /// What is emitted, and what the formula goes on from, of an exact c₀.
    pub fn counts(self, exact: f64) -> (f64, f64) {
        match self {
            First::Exact => (exact, exact),
            First::Reduced => (0.676 * exact, 0.676 * exact),
            First::C1 => (exact, 0.676 * exact),
        }
    }

    /// The part of the acceleration that the ramp has in truth.
    pub fn part(self) -> f64 {
        if self == First::Exact { 0.676 * 0.676 } else { 1.0 }
    }

    /// For the summary: the first delay.
    pub fn value(self, ticks: f64) -> PlanValue {
        let (given, how) = match self {
            First::Exact => ("exact", "Eq 7"),
            First::Reduced => ("0.676", "0.676 of Eq 7"),
            First::C1 => ("c1", "Eq 7; the second is 0.4056 of it"),
        };
        PlanValue {
            name: "first delay",
            shown: format!("{ticks:.2} ticks ({how})"),
            given: given.into(),
            held: ticks,
            unit: "ticks",
        }
    }
}

/// What the change of a step is divided by, in Austin's general form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Divide {
    /// 2c/(4n+1), Eq 12
    #[default]
    #[cfg_attr(feature = "clap", value(name = "4n+1"))]
    FourN,
    /// c/2n, the article's variant: the first delay is √π/2 of the exact one
    #[cfg_attr(feature = "clap", value(name = "2n"))]
    TwoN,
}
