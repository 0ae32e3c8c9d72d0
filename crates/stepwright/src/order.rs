//! Orders, and why they are refused.

use crate::profile::{Path, Ramp, RampSteps, SCurve, Unfit};
use crate::units::{Accel, Jerk, Rate, Speed};
use core::fmt;

/// How far to travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Travel {
    /// This many steps, forward or backward; 0 is a travel that ends at once.
    By(i32),
    /// Without an end, until it is stopped; forward if true.
    Endless(bool),
}

impl Travel {
    /// Whether the travel goes forward.
    pub const fn forward(self) -> bool {
        match self {
            Travel::By(steps) => steps >= 0,
            Travel::Endless(forward) => forward,
        }
    }
}

/// The motion of one axis: speeds, ramps and distance.
///
/// ```
/// use stepwright::{Order, Speed, Travel, profile::Ramp};
/// let order = Order {
///     start: Speed::from_steps(50)?,
///     top: Speed::from_steps(1000)?,
///     up: Ramp::Steps(200),
///     down: Ramp::Steps(200),
///     jerk: None,
///     travel: Travel::By(-4000),
/// };
/// assert!(!order.travel.forward());
/// # Ok::<(), stepwright::OutOfRange>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    /// The speed that the motor jumps to and stops from; may be 0.
    pub start: Speed,
    /// The speed after the ramp. At or below the start speed there is no ramp.
    pub top: Speed,
    /// The ramp from start to top speed.
    pub up: Ramp,
    /// The ramp from top to start speed.
    pub down: Ramp,
    /// The jerk limit at both ends of each ramp, which makes an S-curve. `None`: the acceleration
    /// changes at once.
    pub jerk: Option<Jerk>,
    /// How far to travel.
    pub travel: Travel,
}

impl Order {
    /// The law of this order on a timer.
    ///
    /// # Errors
    /// [`Unfit::NoRamp`] for a ramp of 0 steps; [`Unfit::Jerk`] with a limit of jerk,
    /// which [`SCurve`](crate::profile::SCurve) keeps.
    pub fn law(&self, rate: Rate) -> Result<RampSteps, Unfit> {
        if self.jerk.is_some() {
            return Err(Unfit::Jerk);
        }
        RampSteps::mixed(rate, self.start, self.top, self.up, self.down)
    }

    /// The law of an order with a jerk limit; `None` without one. A ramp in steps stands for the
    /// acceleration that it would have without a jerk limit.
    ///
    /// # Errors
    /// [`Unfit::NoRamp`] for a ramp of 0 steps.
    pub fn s_curve(&self, rate: Rate) -> Option<Result<SCurve, Unfit>> {
        let jerk = self.jerk?;
        let law = |up, down| SCurve::new(rate, self.start, self.top, up, jerk).with_decel(down);
        let both = self.accel(self.up).and_then(|up| Ok((up, self.accel(self.down)?)));
        Some(both.map(|(up, down)| law(up, down)))
    }

    /// The acceleration of a ramp of this order, to 0.001 steps/s².
    ///
    /// # Errors
    /// [`Unfit::NoRamp`] for a ramp of 0 steps.
    pub fn accel(&self, ramp: Ramp) -> Result<Accel, Unfit> {
        let squared = |v: Speed| u64::from(v.millisteps()).pow(2);
        match ramp {
            Ramp::Accel(accel) => Ok(accel),
            Ramp::Steps(0) => Err(Unfit::NoRamp),
            // From 10⁻⁶ (steps/s)² per step to 10⁻³ steps/s².
            Ramp::Steps(steps) => {
                let rise = squared(self.top).saturating_sub(squared(self.start));
                let by = 2000 * u64::from(steps);
                let accel = rise.saturating_add(by / 2).checked_div(by).unwrap_or(0);
                let least = Accel::MIN.millisteps();
                Ok(Accel::from_millisteps(accel.max(least)).unwrap_or(Accel::MAX))
            }
        }
    }

    /// The motion of this order in closed form.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent the motion.
    pub fn path(&self, rate: Rate) -> Result<Path, Unfit> {
        let law = self.law(rate)?;
        match self.travel {
            Travel::By(steps) => law.path(steps.unsigned_abs()),
            Travel::Endless(_) => law.endless(),
        }
    }
}

/// A change of a travel in progress.
///
/// It applies to this travel only; the next order has its own values. The motion continues from its
/// present speed, keeps the limits, and ends exactly on its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The travel ends this many steps from where it began. If the target lies behind, or can't be
    /// reached without overshooting, the axis brakes to rest and travels back. An endless travel
    /// ends here.
    Target(i32),
    /// Another top speed; not below the start speed, with which the travel ends. A travel that was
    /// ordered without ramps (in steps, with a top speed not above its start speed) needs an
    /// [`Accel`](Change::Accel) and a [`Decel`](Change::Decel) first.
    Top(Speed),
    /// The acceleration from now on.
    Accel(Accel),
    /// The deceleration from now on; with a lower one the axis may overshoot its target and come
    /// back.
    Decel(Accel),
}

/// Why an order was refused. Axes at rest stay at rest, and moving axes continue unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The axis is still moving.
    Busy,
    /// The axis is at rest: there is no travel to change.
    Resting,
    /// The axis does not exist.
    NoAxis,
    /// Too fast for this board with this many axes moving: at most `max` for this axis now.
    TooFast {
        /// The highest speed that would be accepted.
        max: Speed,
    },
    /// The ramps of this axis, or of one beside it, need more runs than the board can plan for all
    /// that moves.
    TooSteep {
        /// Runs a second that are left for this axis: see [`Board::runs`](crate::Board::runs).
        runs: u16,
    },
    /// The timer can't represent the motion.
    Unfit(Unfit),
}

impl Refusal {
    /// The name of the reason, as in the status line.
    pub const fn name(self) -> &'static str {
        match self {
            Refusal::Busy => "busy",
            Refusal::Resting => "no-travel",
            Refusal::NoAxis => "no-axis",
            Refusal::TooFast { .. } => "too-fast",
            Refusal::TooSteep { .. } => "too-steep",
            Refusal::Unfit(Unfit::TooSlow | Unfit::BelowStart) => "too-slow",
            Refusal::Unfit(Unfit::TooLong) => "too-long",
            Refusal::Unfit(Unfit::Standstill) => "standstill",
            Refusal::Unfit(Unfit::NoRamp) => "no-ramp",
            Refusal::Unfit(Unfit::TooGentle) => "too-gentle",
            Refusal::Unfit(Unfit::Uneven) => "uneven",
            Refusal::Unfit(Unfit::Jerk) => "jerk",
        }
    }
}

impl From<Unfit> for Refusal {
    fn from(unfit: Unfit) -> Refusal {
        Refusal::Unfit(unfit)
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Busy => {
                f.write_str("the axis is still moving: wait, stop it first, or retarget it")
            }
            Refusal::Resting => {
                f.write_str("the axis is at rest: there is no travel to change; move it")
            }
            Refusal::NoAxis => f.write_str("there is no such axis"),
            Refusal::TooFast { max: Speed::ZERO } => f.write_str(
                "too fast for this board: the other moving axes leave no time for this axis; \
                 lower their speeds first",
            ),
            Refusal::TooFast { max } => {
                write!(f, "too fast for this board: at most {max} steps/s for this axis now")
            }
            Refusal::TooSteep { runs } => {
                // Ramps of a steps/s² need (612·a)^0.4 runs a second.
                let runs = u64::from(*runs);
                let accel = runs * (runs * runs * runs).isqrt() / 612;
                write!(
                    f,
                    "too steep for this board: ramps of at most {accel} steps/s² for this axis now, \
                     a thirtieth of that with a limit of jerk"
                )
            }
            Refusal::Unfit(unfit) => unfit.fmt(f),
        }
    }
}

impl core::error::Error for Refusal {}
