//! S-curve: constant acceleration that is reached and left at a limited jerk.
//!
//! ```text
//!   v ▲          ________             phase       jerk   acceleration
//!     │        ╱          ╲           jerk-up      +J    0 … A
//!     │      ╱              ╲         up            0    A
//!     │     ╱                ╲        jerk-down    −J    A … 0
//!     │   ╱                    ╲      cruise        0    0
//!     └─────────────────────────►     jerk-up      −J    0 … −D
//!       1  2  3     4     5 6 7  t    down          0    −D
//!                                     jerk-down    +J    −D … 0
//! ```
//!
//! Between two speeds that differ by Δv a ramp takes Δv/A + A/J, with a part of constant
//! acceleration, or 2·√(Δv/J) without one if that is shorter than 2A/J; its length is that at the
//! mean of both speeds. If the top speed is out of reach, the fastest curve within the limits
//! consists of the remaining parts. The m pulses are at s = 0 … m − 1 of it, the first at time 0.
//! As the jerk grows, the curve becomes the [trapezoid](super::trapezoid).
//!
//! **Changes**: [`SCurve::from_state`] makes a new motion from the speed and acceleration at any
//! moment, with new limits, to another target, nearer, further or behind; [`SCurve::stop`] makes a
//! soft stop. [`Tracer::change`] changes to it without losing a fraction of a tick.
//!
//! **Error** of every pulse: below one tick, or 2⁻⁴⁰ of the elapsed time if that is larger (0.94
//! ticks by construction). **Cost**: planning a curve takes a PC some 50 µs, a run 2 µs, a step of
//! a profile two additions. The arithmetic has 128-bit integers: for hosts.
//!
//! | file | what |
//! | --- | --- |
//! | `course` | the jerk over time: from any state to rest at a target |
//! | `curve` | the same in closed form: the time of pulse n |
//! | `state` | a new motion from any moment |
//! | `tracer` | the runs of a curve |

mod course;
mod curve;
mod state;
mod tracer;

pub use curve::Curve;
pub use state::State;
pub use tracer::Tracer;

use super::{Delays, Unfit};
use crate::units::{Accel, Jerk, Rate, Speed};
use crate::wide::Wide;
use course::{Limits, Motion};

/// A travel with a limited jerk.
///
/// ```
/// use stepwright::{Accel, Jerk, Rate, Speed, profile::SCurve};
/// let law = SCurve::new(
///     Rate::MHZ,
///     Speed::ZERO,
///     Speed::from_steps(1000)?,
///     Accel::from_steps(4000)?,
///     Jerk::from_steps(48_000)?,
/// );
/// let delays: Vec<u32> = law.delays(2001)?.collect();
/// assert_eq!(delays.len(), 2001);
/// // From rest the first step takes ∛(6/J) …
/// assert_eq!(delays[1], 50_000);
/// // … and all of them the cruise's time and once the ramp's: Δv/A + A/J.
/// assert_eq!(delays.iter().sum::<u32>(), 2_000_000 + 250_000 + 83_333);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SCurve {
    rate: Rate,
    start: Speed,
    top: Speed,
    up: Accel,
    down: Accel,
    jerk: Jerk,
}

impl SCurve {
    /// From `start` (may be 0) at no more than `accel` to `top`, and back at the same rate; the
    /// acceleration changes by `jerk` per second. If the top speed is not above the start speed,
    /// the whole travel is at the top speed.
    pub const fn new(rate: Rate, start: Speed, top: Speed, accel: Accel, jerk: Jerk) -> SCurve {
        SCurve { rate, start, top, up: accel, down: accel, jerk }
    }

    /// This travel with another deceleration.
    pub const fn with_decel(self, decel: Accel) -> SCurve {
        SCurve { down: decel, ..self }
    }

    /// The limits in steps and seconds, with the end speed `end`.
    fn limits(&self, end: Wide) -> Limits {
        Limits {
            top: thousandths(self.top.millisteps().into()),
            up: thousandths(self.up.millisteps()),
            down: thousandths(self.down.millisteps()),
            jerk: thousandths(self.jerk.millisteps()),
            end,
        }
    }

    /// The motion in closed form, with `pulses` pulses: 0 … 2³¹.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn curve(&self, pulses: u32) -> Result<Curve, Unfit> {
        if pulses > 1 << 31 {
            return Err(Unfit::TooLong);
        }
        if self.top == Speed::ZERO {
            return Err(Unfit::Standstill);
        }
        let start = thousandths(self.start.min(self.top).millisteps().into());
        let length = pulses.saturating_sub(1).into();
        let curve = Curve::new(self.rate, &self.limits(start), Motion::steady(start), length)?;
        Ok(curve.of(pulses))
    }

    /// The delay before each of `pulses` pulses; the first is 0.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub fn delays(&self, pulses: u32) -> Result<Delays<Tracer>, Unfit> {
        Ok(Delays::of_curve(self.curve(pulses)?))
    }
}

fn thousandths(n: u64) -> Wide {
    Wide::whole(n) / Wide::whole(1000)
}
