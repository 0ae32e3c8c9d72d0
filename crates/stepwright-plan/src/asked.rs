//! What every law with an acceleration and a top speed is asked for.

use stepwright::{Accel, Rate, Speed};
use stepwright_austin::C0;
use stepwright_units::Rounded;

use crate::equations::Counter;
use crate::law::PlanValue;
use crate::sheet::Cell;

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

    /// The delay of the top speed in ticks, at least one.
    pub(crate) fn least(&self) -> f64 {
        self.motor().delay(self.speed()).max(1.0)
    }

    /// What is said of an acceleration that is lowered.
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

    /// For the summary: the first delay, no shorter than `least`, that of the top speed.
    pub fn value(self, ticks: f64, least: f64) -> PlanValue {
        let (given, how) = match self {
            First::Exact => ("exact", "Eq 7"),
            First::Reduced => ("0.676", "0.676 of Eq 7"),
            First::C1 => ("c1", "Eq 7; the second is 0.4056 of it"),
        };
        first_delay(given, how, ticks, least)
    }
}

/// A first delay by `how`, which is no shorter than `least`.
pub(crate) fn first_delay(given: &str, how: &str, ticks: f64, least: f64) -> PlanValue {
    let shown = match ticks < least {
        true => format!("{least:.2} ticks (the top speed; {ticks:.2} by {how})"),
        false => format!("{ticks:.2} ticks ({how})"),
    };
    let held = ticks.max(least);
    PlanValue { name: "first delay", shown, given: given.into(), held, unit: "ticks" }
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
