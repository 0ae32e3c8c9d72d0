//! What an axis is allowed: set once, kept by every move.

use crate::order::{Order, Travel};
use crate::profile::Ramp;
use crate::units::{Accel, Jerk, Speed};

/// The limits of an axis: its highest speed and how fast the speed may change.
///
/// A move speeds up from the start speed with the acceleration, cruises at the highest
/// speed, slows down with the deceleration and ends at the start speed.
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
    /// The speed of every move that is long enough to reach it.
    pub max_speed: Speed,
    /// From the start speed to the highest.
    pub acceleration: Accel,
    /// From the highest speed to the start speed; also what a stop takes.
    pub deceleration: Accel,
    /// The speed that the motor jumps to from rest and stops from; 0 is allowed.
    pub start_speed: Speed,
    /// The limit of the jerk, which makes an S-curve, on boards that have it. `None`: no limit,
    /// a trapezoid.
    pub jerk: Option<Jerk>,
}

impl AxisLimits {
    /// What an axis has until it is told otherwise: 500 steps/s, 1,000 steps/s², from rest,
    /// without a limit of jerk. Slow enough for any usual motor in full steps.
    pub const DEFAULT: AxisLimits = AxisLimits::new(Speed::of::<500>(), Accel::of::<1_000>());

    /// Limits of this speed and this acceleration. The deceleration is the same, the start
    /// speed is 0, the jerk is not limited.
    pub const fn new(max_speed: Speed, acceleration: Accel) -> AxisLimits {
        AxisLimits {
            max_speed,
            acceleration,
            deceleration: acceleration,
            start_speed: Speed::ZERO,
            jerk: None,
        }
    }

    /// The same with another deceleration.
    #[must_use]
    pub const fn deceleration(self, deceleration: Accel) -> AxisLimits {
        AxisLimits { deceleration, ..self }
    }

    /// The same with another start speed.
    #[must_use]
    pub const fn start_speed(self, start_speed: Speed) -> AxisLimits {
        AxisLimits { start_speed, ..self }
    }

    /// The same with a limit of jerk: an S-curve.
    #[must_use]
    pub const fn jerk(self, jerk: Jerk) -> AxisLimits {
        AxisLimits { jerk: Some(jerk), ..self }
    }

    /// The order of a travel that keeps these limits.
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

    /// The limits of the longest way of a line, `furthest` pulses, so that an axis of
    /// `pulses` keeps its own limits, these, when it is scaled by its share.
    pub(super) fn stretched(&self, pulses: u32, furthest: u32) -> AxisLimits {
        // The share is counted between the first pulse and the last: see `Order::split_line`.
        let (part, whole) = (pulses.saturating_sub(1), furthest.saturating_sub(1));
        if part == whole {
            return *self;
        }
        // Less than 2^60 · 2^31: not in 64 bits.
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
