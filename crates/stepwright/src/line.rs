//! A straight line of several axes, by one order.
//!
//! Every axis follows the law of the axis with the longest way, scaled by its share of that way. So
//! all axes begin together, end together, and stay on the line all the time. Between its first and
//! its last pulse an axis makes one step less than it makes pulses, so
//!
//! ```text
//!   share = (n − 1) / (n_furthest − 1)       start, top, a, d, jerk · share
//! ```
//!
//! **Error.** Speeds are rounded to 0.001 steps/s and accelerations to 0.001 steps/s². At a share
//! of 20 steps/s the error is 2.5 · 10⁻⁵ of the time. So an axis stays on the line to a step while
//! it travels less than some 10,000 times as fast as that. A single step is made at the beginning.

use crate::order::{Order, Travel};
use crate::profile::{Ramp, Unfit};
use crate::units::{Accel, Jerk, Speed};

impl Order {
    /// The orders for the axes of a group that move it along a straight line: axis 0 by `way[0]`
    /// steps, axis 1 by `way[1]`, … The speeds and ramps of this order are those of the axis with
    /// the longest way; its own travel is ignored. An axis with 0 steps gets no order.
    ///
    /// ```
    /// use stepwright::{Accel, Order, Speed, Travel, profile::Ramp};
    /// let ramp = Ramp::Accel(Accel::from_steps(8_000)?);
    /// let (start, top) = (Speed::ZERO, Speed::from_steps(4_000)?);
    /// let order = Order { start, top, up: ramp, down: ramp, jerk: None, travel: Travel::By(0) };
    /// let orders: Vec<_> = order.split_line([3_001, -1_501, 0])?.collect();
    /// assert_eq!(orders.len(), 2);
    /// assert_eq!(orders[1].1.top, Speed::from_steps(2_000)?);
    /// assert_eq!((orders[1].0, orders[1].1.travel), (1, Travel::By(-1_501)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`Unfit::NoRamp`] for a ramp of 0 steps.
    pub fn split_line<const N: usize>(
        &self,
        way: [i32; N],
    ) -> Result<impl Iterator<Item = (u8, Order)>, Unfit> {
        let (order, up, down) = (*self, self.accel(self.up)?, self.accel(self.down)?);
        let furthest = way.iter().map(|steps| steps.unsigned_abs()).max().unwrap_or(0);
        let moving = (0..).zip(way).filter(|(_, steps)| *steps != 0);
        Ok(moving.map(move |(axis, steps)| {
            let travel = Travel::By(steps);
            let share = Share::of(steps.unsigned_abs(), furthest);
            if share.part == share.whole {
                return (axis, Order { travel, ..order });
            }
            let ramp = |accel| Ramp::Accel(share.accel(accel));
            let (start, top) = (share.speed(order.start, 0), share.speed(order.top, 1));
            let jerk = order.jerk.map(|jerk| share.jerk(jerk));
            (axis, Order { start, top, up: ramp(up), down: ramp(down), jerk, travel })
        }))
    }
}

/// A share of the longest way; the whole of it if the longest way has no interval.
#[derive(Clone, Copy)]
struct Share {
    part: u64,
    whole: u64,
}

impl Share {
    fn of(pulses: u32, furthest: u32) -> Share {
        let (part, whole) = (pulses.saturating_sub(1), furthest.saturating_sub(1));
        if part == 0 {
            Share { part: 1, whole: 1 }
        } else {
            Share { part: part.into(), whole: whole.into() }
        }
    }

    /// `x` times the share, rounded to nearest; at least `least`.
    fn number(self, x: u64, least: u64) -> u64 {
        // The product is below 2^60 · 2^31 and needs more than 64 bits.
        let product = u128::from(x) * u128::from(self.part) + u128::from(self.whole / 2);
        let share = product.checked_div(self.whole.into()).unwrap_or(0);
        // The result is at most x.
        u64::try_from(share).unwrap_or(x).max(least)
    }

    fn speed(self, v: Speed, least: u64) -> Speed {
        let share = self.number(v.millisteps().into(), least.min(v.millisteps().into()));
        u32::try_from(share).ok().and_then(|v| Speed::from_millisteps(v).ok()).unwrap_or(v)
    }

    fn accel(self, a: Accel) -> Accel {
        Accel::from_millisteps(self.number(a.millisteps(), 1)).unwrap_or(a)
    }

    fn jerk(self, jerk: Jerk) -> Jerk {
        Jerk::from_millisteps(self.number(jerk.millisteps(), 1)).unwrap_or(jerk)
    }
}
