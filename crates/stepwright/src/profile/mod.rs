//! Ramp laws: the ticks until the next step.
//!
//! A profile is an [`Iterator`] over [`Ticks`](crate::Ticks) with no hardware, no clock and no
//! allocation: `m` pulses are `m` delays, each the time *before* its pulse. The first delay is 0
//! unless the profile says otherwise.
//!
//! A law with a closed form also has a [`Path`]: the time of pulse `n`, and the [run](crate::Run)
//! that begins at it.
//!
//! | law | file | closed form |
//! | --- | --- | --- |
//! | constant speed | [`constant`] | yes |
//! | lists, callbacks, waits | [`series`] | – |
//! | trapezoid: constant acceleration and deceleration | [`trapezoid`] | yes |
//! | ramp counted in steps (the Nano slave) | [`ramp_steps`] | yes |
//! | S-curve: limited jerk | [`s_curve`] | yes |

mod cursor;
pub(crate) mod path;

pub mod constant;
pub mod ramp_steps;
pub mod s_curve;
pub mod series;
pub mod trapezoid;

pub use cursor::{Cursor, Fit};
pub use path::{Bounds, Path, Phase, slope_of};
pub use ramp_steps::{Ramp, RampSteps};
pub use s_curve::{Curve, SCurve, State, Tracer};
pub use series::{Part, Series};
pub use trapezoid::Trapezoid;

use crate::run::{Run, Steps};
use core::fmt;

/// Runs with a known number of steps, from which [`Delays`] are made.
pub trait Runs: Iterator<Item = Run> {
    /// The number of steps left; `u32::MAX` if there is no end.
    fn steps_left(&self) -> u32;
}

/// The pulses of a [`Path`] or a [`Curve`] as delays in ticks, each within a tick of the closed
/// form. The first is 0.
///
/// The runs behind it are fitted to a quarter of a tick: a step takes two additions, and the closed
/// form is evaluated once per run.
#[derive(Clone, Debug)]
pub struct Delays<R = Cursor> {
    /// Whether the pulse at time 0 is still to come.
    first: bool,
    steps: Steps<R>,
}

impl Delays {
    pub(crate) fn new(path: Path) -> Delays {
        Delays { first: path.pulses() > 0, steps: Steps::new(Cursor::new(path, Fit::EXACT)) }
    }
}

impl Delays<Tracer> {
    pub(crate) fn of_curve(curve: Curve) -> Delays<Tracer> {
        Delays { first: curve.pulses() > 0, steps: Steps::new(Tracer::new(curve, Fit::EXACT)) }
    }
}

impl<R: Runs> Iterator for Delays<R> {
    type Item = crate::Ticks;

    #[inline]
    fn next(&mut self) -> Option<crate::Ticks> {
        if core::mem::take(&mut self.first) {
            return Some(0);
        }
        self.steps.next()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let (runs, run) = self.steps.remaining();
        let left = u64::from(runs.steps_left()) + u64::from(run) + u64::from(self.first);
        let left = usize::try_from(left).unwrap_or(usize::MAX);
        (left, Some(left))
    }

    #[inline]
    fn fold<B, F: FnMut(B, crate::Ticks) -> B>(self, init: B, mut f: F) -> B {
        let init = if self.first { f(init, 0) } else { init };
        self.steps.fold(init, f)
    }
}

impl<R: Runs> ExactSizeIterator for Delays<R> {}

/// Why a timer can't represent a travel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfit {
    /// Two steps would be more than 2³¹ ticks apart (the limit of a law in closed form) or more
    /// than 2³² (the limit of an axis): the speed or the acceleration is too low for this timer.
    TooSlow,
    /// More than 2³¹ − 1 steps in a travel, in either direction; a law in closed form has one pulse
    /// more.
    TooLong,
    /// The top speed is 0.
    Standstill,
    /// The ramp has no steps.
    NoRamp,
    /// A travel in progress would continue below the start speed, with which it ends.
    BelowStart,
    /// The ramps are too gentle for the top speed: they would take 2³¹ steps or more, or there are
    /// none, because the top speed that was ordered is not above the start speed.
    TooGentle,
    /// The ramps up and down differ, but the law uses its ramp in reverse.
    Uneven,
    /// The order limits the jerk, but the law does not.
    Jerk,
}

impl Unfit {
    /// What is wrong.
    pub const fn what(self) -> &'static str {
        self.parts().0
    }

    /// What is allowed, or what to do.
    pub const fn remedy(self) -> &'static str {
        self.parts().2
    }

    /// What is wrong, the separator, and what to do.
    const fn parts(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Unfit::TooSlow => (
                "too slow for this timer: two steps would lie more than 2^31 ticks apart",
                "; ",
                "raise the speed or the acceleration, or use a slower timer",
            ),
            Unfit::TooLong => ("too many steps", ": ", "at most 2147483647 in a travel"),
            Unfit::Standstill => ("the top speed is 0", ": ", "give a speed above 0"),
            Unfit::NoRamp => ("the ramp has no steps", ": ", "give 1 or more"),
            Unfit::BelowStart => (
                "below the start speed, at which this travel ends",
                ": ",
                "give that or more, or stop and start again",
            ),
            Unfit::TooGentle => (
                "the ramps are too gentle for this speed, or there are none, as in a travel at \
                 its start speed",
                ": ",
                "raise acceleration and deceleration first, or lower the top speed",
            ),
            Unfit::Jerk => ("this law knows no limit of jerk", ": ", "take the S-curve"),
            Unfit::Uneven => ("this law brakes as it speeds up", ": ", "give both ramps alike"),
        }
    }
}

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, between, remedy) = self.parts();
        write!(f, "{what}{between}{remedy}")
    }
}

impl core::error::Error for Unfit {}
