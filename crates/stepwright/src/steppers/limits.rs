//! The limits of an axis: set once, kept by every move.

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

    /// The limits of an imaginary axis with the longest way of a line, `furthest` pulses: scaled
    /// down by its share, an axis of `pulses` pulses then keeps these limits, its own.
    pub(super) fn stretched(&self, pulses: u32, furthest: u32) -> AxisLimits {
        // The share counts the intervals between the first pulse and the last: see
        // `Order::split_line`.
        let (part, whole) = (pulses.saturating_sub(1), furthest.saturating_sub(1));
        if part == whole {
            return *self;
        }
        // The product is below 2^60 · 2^31 and needs more than 64 bits.
        let stretch = |x: u64| {
            let product = u128::from(x) * u128::from(whole);
            let stretched = product.checked_div(part.into()).unwrap_or(product);
            u64::try_from(stretched).unwrap_or(u64::MAX)
        };
        let speed = |v: Speed| {
            let v = u32::try_from(stretch(v.millisteps().into())).unwrap_or(u32::MAX);
            Speed::from_millisteps(v).unwrap_or(Speed::MAX)
        };
        let accel =
            |a: Accel| Accel::from_millisteps(stretch(a.millisteps())).unwrap_or(Accel::MAX);
        let jerk = |j: Jerk| Jerk::from_millisteps(stretch(j.millisteps())).unwrap_or(Jerk::MAX);
        AxisLimits {
            max_speed: speed(self.max_speed),
            acceleration: accel(self.acceleration),
            deceleration: accel(self.deceleration),
            start_speed: speed(self.start_speed),
            jerk: self.jerk.map(jerk),
        }
    }

    /// The stricter of each limit.
    pub(super) fn stricter(&self, other: &AxisLimits) -> AxisLimits {
        AxisLimits {
            max_speed: self.max_speed.min(other.max_speed),
            acceleration: self.acceleration.min(other.acceleration),
            deceleration: self.deceleration.min(other.deceleration),
            start_speed: self.start_speed.min(other.start_speed),
            jerk: match (self.jerk, other.jerk) {
                (Some(own), Some(other)) => Some(own.min(other)),
                (own, other) => own.or(other),
            },
        }
    }
}

impl Default for AxisLimits {
    fn default() -> AxisLimits {
        AxisLimits::DEFAULT
    }
}
