//! The inputs that every law with an acceleration and a top speed needs.

use stepwright::{Accel, Rate, Speed};
use stepwright_austin::C0;
use stepwright_units::Rounded;

use crate::equations::Counter;
use crate::law::PlanValue;
use crate::sheet::Cell;

/// A travel and its limits, in the units of the core.
#[derive(Clone, Debug)]
pub struct PlanLimits {
    /// The rate of the step timer.
    pub rate: Rate,
    /// The travel in pulses.
    pub steps: u32,
    /// Acceleration.
    pub accel: Rounded<Accel>,
    /// Deceleration; the acceleration unless it was given.
    pub decel: Rounded<Accel>,
    /// Top speed.
    pub top: Rounded<Speed>,
}

impl PlanLimits {
    /// The limits as lines of the summary.
    pub fn values(&self) -> Vec<PlanValue> {
        vec![
            PlanValue::speed("top speed", &self.top),
            PlanValue::accel("acceleration", &self.accel),
            PlanValue::accel("deceleration", &self.decel),
        ]
    }

    /// The timer and a motor whose angles are counted in steps, for Austin's equations.
    pub fn motor(&self) -> Counter {
        Counter { hz: self.rate.hz().into(), step: 1.0 }
    }

    /// Top speed in steps/s.
    pub fn speed(&self) -> f64 {
        f64::from(self.top.value.millisteps()) / 1e3
    }

    /// The delay of the top speed in ticks, at least one.
    pub(crate) fn least(&self) -> f64 {
        self.motor().delay(self.speed()).max(1.0)
    }

    /// The note for the summary if the acceleration is lowered.
    pub(crate) fn lowered(&self) -> Option<String> {
        let (accel, _) = self.accels();
        (accel < self.accel.value.millisteps() as f64 / 1e3).then(|| {
            format!(
                "the acceleration is lowered to {} steps/s²: more could not be braked from behind \
                 the first step",
                Cell::digits(accel, 9).shown(),
            )
        })
    }

    /// Acceleration and deceleration in steps/s². Lowers an acceleration whose first step would already be
    /// too fast to brake from, as the core does: to the value that gives J = m − ½ in Eq 18.
    pub fn accels(&self) -> (f64, f64) {
        let held = |a: &Rounded<Accel>| a.value.millisteps() as f64 / 1e3;
        let (accel, decel) = (held(&self.accel), held(&self.decel));
        (accel.min((2.0 * f64::from(self.steps.max(1)) - 1.0) * decel), decel)
    }
}

/// How one of Austin's ramps begins: its first delay c₀. After an exact c₀, Eq 12 gives too long delays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum First {
    /// Eq 7 unchanged: all delays are too long, the acceleration is 0.457 of the one given
    Exact,
    /// 0.676 times Eq 7 (Eq 15), as the article recommends
    #[cfg_attr(feature = "clap", value(name = "0.676"))]
    Reduced,
    /// Eq 7, and the second delay is 0.4056 of the first
    C1,
}

impl First {
    /// The same as a type of the core.
    pub fn core(self) -> C0 {
        match self {
            First::Exact => C0::Exact,
            First::Reduced => C0::Reduced,
            First::C1 => C0::FirstStep,
        }
    }

    /// For an exact c₀: the delay that is emitted, and the delay that the formula continues from.
    pub fn counts(self, exact: f64) -> (f64, f64) {
        match self {
            First::Exact => (exact, exact),
            First::Reduced => (0.676 * exact, 0.676 * exact),
            First::C1 => (exact, 0.676 * exact),
        }
    }

    /// The fraction of the given acceleration that the ramp really has.
    pub fn part(self) -> f64 {
        if self == First::Exact { 0.676 * 0.676 } else { 1.0 }
    }

    /// The first delay for the summary, at least `least`, the delay of the top speed.
    pub fn value(self, ticks: f64, least: f64) -> PlanValue {
        let (given, how) = match self {
            First::Exact => ("exact", "Eq 7"),
            First::Reduced => ("0.676", "0.676 of Eq 7"),
            First::C1 => ("c1", "Eq 7; the second is 0.4056 of it"),
        };
        first_delay(given, how, ticks, least)
    }
}

/// A first delay of `ticks` by the formula `how`, raised to `least`.
pub(crate) fn first_delay(given: &str, how: &str, ticks: f64, least: f64) -> PlanValue {
    let shown = match ticks < least {
        true => format!("{least:.2} ticks (the top speed; {ticks:.2} by {how})"),
        false => format!("{ticks:.2} ticks ({how})"),
    };
    let held = ticks.max(least);
    PlanValue { name: "first delay", shown, given: given.into(), held, unit: "ticks" }
}

/// The divisor of the change per step in Austin's general form.
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
