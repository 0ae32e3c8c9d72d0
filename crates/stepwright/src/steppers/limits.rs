//! The limits of an axis: set once, kept by every move.

use crate::line::Ratio;
use crate::order::{Order, Travel};
use crate::profile::Ramp;
use crate::units::{Accel, Jerk, Speed};

/// The limits of an axis: its top speed, and how fast the speed may change.
///
/// A move accelerates from the start speed, cruises at the top speed, decelerates and ends at the
/// start speed.
///
/// ```
/// use stepwright::{Accel, AxisLimits, Speed};
/// const LIMITS: AxisLimits = AxisLimits::new(Speed::of::<4_000>(), Accel::of::<10_000>())
///     .deceleration(Accel::of::<20_000>())
///     .start_speed(Speed::of::<50>());
/// assert_eq!(LIMITS.max_speed.to_string(), "4000");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisLimits {
    /// The top speed of every move that is long enough to reach it.
    pub max_speed: Speed,
    /// Acceleration from the start speed to the top speed.
    pub acceleration: Accel,
    /// Deceleration from the top speed to the start speed; also that of a stop.
    pub deceleration: Accel,
    /// The speed that the motor jumps to from rest and stops from; may be 0.
    pub start_speed: Speed,
    /// The jerk limit, which makes an S-curve, on boards that support it. `None`: no limit, a
    /// trapezoid.
    pub jerk: Option<Jerk>,
}

impl AxisLimits {
    /// The limits of an axis before they are set: 500 steps/s, 1,000 steps/s², start speed 0, no
    /// jerk limit. Slow enough for any usual motor in full steps.
    pub const DEFAULT: AxisLimits = AxisLimits::new(Speed::of::<500>(), Accel::of::<1_000>());

    /// Limits with this top speed and this acceleration. The deceleration is the same as the
    /// acceleration, the start speed is 0, the jerk is not limited.
    pub const fn new(max_speed: Speed, acceleration: Accel) -> AxisLimits {
        AxisLimits {
            max_speed,
            acceleration,
            deceleration: acceleration,
            start_speed: Speed::ZERO,
            jerk: None,
        }
    }

    /// These limits with another deceleration.
    #[must_use]
    pub const fn deceleration(self, deceleration: Accel) -> AxisLimits {
        AxisLimits { deceleration, ..self }
    }

    /// These limits with another start speed.
    #[must_use]
    pub const fn start_speed(self, start_speed: Speed) -> AxisLimits {
        AxisLimits { start_speed, ..self }
    }

    /// These limits with a jerk limit: an S-curve.
    #[must_use]
    pub const fn jerk(self, jerk: Jerk) -> AxisLimits {
        AxisLimits { jerk: Some(jerk), ..self }
    }

    /// The order of a travel with these limits.
    pub const fn order(&self, travel: Travel) -> Order {
        Order {
            start: self.start_speed,
            top: self.max_speed,
            up: Ramp::Accel(self.acceleration),
            down: Ramp::Accel(self.deceleration),
            jerk: self.jerk,
            travel,
        }
    }

    /// Limits that allow everything.
    pub(super) const NONE: AxisLimits = AxisLimits {
        max_speed: Speed::MAX,
        acceleration: Accel::MAX,
        deceleration: Accel::MAX,
        start_speed: Speed::MAX,
        jerk: None,
    };

    /// Lowers these limits, those of the longest way of a line, `furthest` pulses, so that an axis
    /// of `pulses` pulses, scaled down by its share, keeps its own. The share counts the intervals
    /// between the first pulse and the last: see [`Order::split_line`].
    #[inline(never)]
    pub(super) fn tighten(&mut self, own: &AxisLimits, pulses: u32, furthest: u32) {
        let stretch = Ratio::new(furthest.saturating_sub(1), pulses.saturating_sub(1));
        // The lower of two values is in range.
        let lower_speed = |all: &mut Speed, own: Speed| {
            let v = stretch.of(own.millisteps().into()).min(all.millisteps().into());
            *all = Speed::from_millisteps(v as u32).unwrap_or(*all);
        };
        let lower_accel = |all: &mut Accel, own: Accel| {
            let a = stretch.of(own.millisteps()).min(all.millisteps());
            *all = Accel::from_millisteps(a).unwrap_or(*all);
        };
        lower_speed(&mut self.max_speed, own.max_speed);
        lower_accel(&mut self.acceleration, own.acceleration);
        lower_accel(&mut self.deceleration, own.deceleration);
        lower_speed(&mut self.start_speed, own.start_speed);
        if let Some(own) = own.jerk {
            let all = self.jerk.unwrap_or(Jerk::MAX);
            // Without the feature it is refused.
            let j = if cfg!(feature = "jerk") { stretch.of(own.millisteps()) } else { 1 };
            let j = j.min(all.millisteps());
            self.jerk = Some(Jerk::from_millisteps(j).unwrap_or(all));
        }
    }
}

impl Default for AxisLimits {
    fn default() -> AxisLimits {
        AxisLimits::DEFAULT
    }
}
