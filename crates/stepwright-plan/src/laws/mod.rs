//! The ramp laws, one file each, and modules that some of them share.
//!
//! | module | what |
//! | --- | --- |
//! | `trapezoid`, `ramp` | [`constant`] acceleration, in closed form |
//! | `s_curve` | a limited jerk, in closed form |
//! | `austin`, `austin_fixed`, `linear_factor`, `power`, `piecewise` | Austin's: [`counted`] from delay to delay, beside their [`formula`] |
//! | [`change`] | a ramp that changes its acceleration on its way |
//!
//! A further law is another file and a variant of [`LawChoice`].

mod austin;
mod austin_fixed;
pub(crate) mod change;
pub(crate) mod constant;
pub(crate) mod counted;
pub(crate) mod formula;
mod linear_factor;
mod piecewise;
mod power;
mod ramp;
mod s_curve;
pub(crate) mod trapezoid;

use stepwright::{Geometry, Jerk, Speed};
use stepwright_units::Rounded;

use crate::PlanError;
use crate::asked::{Divide, First, PlanLimits};
use crate::law::{Plan, PlanValue, PlannedLaw};
use crate::watch::Watch;
use change::RampChange;

/// A law with an acceleration and a top speed, and its other parameters.
#[derive(Clone, Debug)]
pub enum LawChoice {
    /// Constant acceleration between the start speed and the top speed.
    Trapezoid {
        /// Speed at both ends.
        start: Rounded<Speed>,
    },
    /// Constant acceleration with a limited jerk.
    SCurve {
        /// Speed at both ends.
        start: Rounded<Speed>,
        /// The jerk: the rate of change of acceleration and deceleration.
        jerk: Rounded<Jerk>,
    },
    /// Austin's general form, from rest.
    Austin {
        /// The first delay.
        c0: First,
        /// The divisor of the change per step.
        divisor: Divide,
        /// Other accelerations on the way up, in the order of their steps.
        changes: Vec<RampChange>,
    },
    /// Austin's linear factor.
    LinearFactor {
        /// The first delay.
        c0: First,
        /// The begin of the factor, in thousandths of the top speed: 0 to 900.
        knee: u16,
    },
    /// Austin's power term.
    Power {
        /// The first delay.
        c0: First,
        /// p, 2 to 9.
        power: u8,
    },
    /// Austin's piecewise ramp.
    Piecewise {
        /// The first delay.
        c0: First,
        /// The number of reductions of the acceleration, 0 to 16.
        breaks: u8,
    },
}

impl LawChoice {
    /// The names of all laws, as on the command line.
    pub const NAMES: [&str; 6] =
        ["trapezoid", "s-curve", "austin", "linear-factor", "power", "piecewise"];

    /// The name of the law: `linear-factor`.
    pub fn name(&self) -> &'static str {
        LawChoice::NAMES[match self {
            LawChoice::Trapezoid { .. } => 0,
            LawChoice::SCurve { .. } => 1,
            LawChoice::Austin { .. } => 2,
            LawChoice::LinearFactor { .. } => 3,
            LawChoice::Power { .. } => 4,
            LawChoice::Piecewise { .. } => 5,
        }]
    }

    /// The law for a travel. Reports its progress to `watch`: a travel of billions of steps takes minutes
    /// with Austin's laws.
    ///
    /// # Errors
    /// [`PlanError::Unfit`]: the core can't hold the travel.
    pub fn law(
        &self,
        limits: &PlanLimits,
        watch: Watch<'_>,
    ) -> Result<Box<dyn PlannedLaw>, PlanError> {
        match self {
            LawChoice::Trapezoid { start } => trapezoid::law(limits, start.value),
            LawChoice::SCurve { start, jerk } => s_curve::law(limits, start.value, jerk.value),
            LawChoice::Austin { c0, divisor, changes } if changes.is_empty() => {
                austin::law(limits, *c0, *divisor, watch)
            }
            LawChoice::Austin { c0, changes, .. } => austin::changing(limits, *c0, changes, watch),
            LawChoice::LinearFactor { c0, knee } => linear_factor::law(limits, *c0, *knee, watch),
            LawChoice::Power { c0, power } => power::law(limits, *c0, *power, watch),
            LawChoice::Piecewise { c0, breaks } => piecewise::law(limits, *c0, *breaks, watch),
        }
    }

    /// The plan: the law with its values.
    ///
    /// # Errors
    /// As for [`law`](LawChoice::law); [`PlanError::TooFast`].
    pub fn plan(
        &self,
        limits: &PlanLimits,
        geometry: &Geometry,
        watch: Watch<'_>,
    ) -> Result<Plan, PlanError> {
        let mut values = limits.values();
        let mut note = None;
        let first =
            |c0: First| c0.value(c0.counts(limits.motor().c0(limits.accels().0)).0, limits.least());
        match self {
            LawChoice::Trapezoid { start } | LawChoice::SCurve { start, .. } => {
                values.insert(0, PlanValue::speed("start speed", start));
                note = no_ramp(start.value, limits.top.value);
                if let LawChoice::SCurve { jerk, .. } = self {
                    values.push(PlanValue::jerk("jerk", jerk));
                }
            }
            LawChoice::Austin { c0, divisor, changes } => {
                values.push(austin::begin(limits, *c0, *divisor));
                values.extend(change::values(changes));
            }
            LawChoice::LinearFactor { c0, knee } => {
                values.extend([first(*c0), linear_factor::knee(limits, *c0, *knee)?]);
            }
            LawChoice::Power { c0, power } => {
                values.extend([first(*c0), power::term(limits, *c0, *power)]);
            }
            LawChoice::Piecewise { c0, breaks } => {
                values.extend([first(*c0), piecewise::stages(*breaks)]);
            }
        }
        if !matches!(self, LawChoice::Trapezoid { .. } | LawChoice::SCurve { .. }) {
            note = limits.lowered();
        }
        let law = self.law(limits, watch)?;
        let plan = Plan::new(self.name(), limits.rate, geometry, values, law)?;
        Ok(Plan { note, ..plan })
    }
}

/// The note for a travel that starts at its top speed or above.
fn no_ramp(start: Speed, top: Speed) -> Option<String> {
    (start >= top).then(|| {
        format!("the start speed is not below the top speed: no ramp, all at {top} steps/s")
    })
}
