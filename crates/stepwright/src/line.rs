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
        let accel = |ramp| Ok(Ramp::Accel(self.accel(ramp)?));
        let (order, accelerated) =
            (*self, Order { up: accel(self.up)?, down: accel(self.down)?, ..*self });
        let furthest = way.iter().map(|steps| steps.unsigned_abs()).max().unwrap_or(0);
        let moving = (0..).zip(way).filter(|(_, steps)| *steps != 0);
        Ok(moving.map(move |(axis, steps)| {
            let whole = Order { travel: Travel::By(steps), ..order };
            (axis, accelerated.part_of_line(steps, furthest).unwrap_or(whole))
        }))
    }

    /// The order of an axis with this way of a line, where the ramps of this order, the whole
    /// line's, are accelerations. `None` for an axis with the longest way, or with one step: it has
    /// all of the line's speed.
    #[inline(never)]
    pub(crate) fn part_of_line(&self, steps: i32, furthest: u32) -> Option<Order> {
        let (part, whole) = (steps.unsigned_abs().saturating_sub(1), furthest.saturating_sub(1));
        if part == 0 || part == whole {
            return None;
        }
        let share = Ratio { whole: 0, rest: part, of: whole };
        let speed = |v: Speed, least: u64| {
            // At most `v`.
            let own = share.of_nearest(v.millisteps().into()).max(least) as u32;
            Speed::from_millisteps(own.min(v.millisteps())).unwrap_or(v)
        };
        let ramp = |ramp| match ramp {
            Ramp::Accel(a) => {
                let own = share.of_nearest(a.millisteps()).max(1);
                Ramp::Accel(Accel::from_millisteps(own).unwrap_or(a))
            }
            steps => steps,
        };
        let jerk = |jerk: Jerk| {
            let own = share.of_nearest(jerk.millisteps()).max(1);
            Jerk::from_millisteps(own).unwrap_or(jerk)
        };
        Some(Order {
            start: speed(self.start, 0),
            top: speed(self.top, 1),
            up: ramp(self.up),
            down: ramp(self.down),
            // Without the feature it is refused.
            jerk: if cfg!(feature = "jerk") { self.jerk.map(jerk) } else { self.jerk },
            travel: Travel::By(steps),
        })
    }
}

/// A factor: `whole + rest / of`, where `rest` is less than `of`, and `of` less than 2^31.
///
/// An exact product needs no more than 64 bits here. A division of `u128` takes 7 KB of an AVR's
/// flash, and the compiler gets it wrong for a Mega; one of `u64` takes 3 KB.
#[derive(Clone, Copy)]
pub(crate) struct Ratio {
    whole: u32,
    rest: u32,
    of: u32,
}

impl Ratio {
    /// `by / of`, both less than 2^31; 1 if they are equal.
    pub(crate) fn new(by: u32, of: u32) -> Ratio {
        if by == of || of == 0 {
            return Ratio { whole: 1, rest: 0, of: 1 };
        } else if of == 1 {
            return Ratio { whole: by, rest: 0, of };
        }
        let whole = Ratio { whole: 0, rest: 1, of }.of(by.into()) as u32;
        Ratio { whole, rest: by.wrapping_sub(whole.wrapping_mul(of)), of }
    }

    /// `x` times the factor, rounded down; 2^63 or more if it is as much.
    pub(crate) fn of(&self, x: u64) -> u64 {
        self.divide(x, self.of)
    }

    /// `x` times the factor, rounded to nearest.
    fn of_nearest(&self, x: u64) -> u64 {
        self.divide(x, self.of - self.of / 2)
    }

    /// `x` times the factor, rounded up from a remainder of `up`.
    ///
    /// ```text
    /// x·(whole·of + rest) = result·of + remainder,   for the bits of x from the highest on
    /// ```
    #[inline(never)]
    fn divide(&self, mut x: u64, up: u32) -> u64 {
        let (mut result, mut remainder, mut bits) = (0u64, 0u32, 64u8);
        if x >> 32 == 0 {
            (x, bits) = (x << 32, 32);
        }
        for _ in 0..bits {
            if result >> 62 != 0 {
                return u64::MAX;
            }
            result *= 2;
            remainder *= 2;
            if remainder >= self.of {
                remainder -= self.of;
                result += 1;
            }
            if x >> 63 != 0 {
                result += u64::from(self.whole);
                remainder += self.rest;
                if remainder >= self.of {
                    remainder -= self.of;
                    result += 1;
                }
            }
            x <<= 1;
        }
        result + u64::from(remainder >= up)
    }
}

#[cfg(test)]
mod tests {
    use super::Ratio;

    const MOST: u32 = i32::MAX as u32;

    #[test]
    fn a_product_is_that_of_128_bits() {
        let xs = [0, 1, 2, 999, 1 << 31, u64::from(u32::MAX), 1 << 60, (1 << 60) - 7, u64::MAX];
        let ns = [1, 2, 3, 299, 1_999, 89_999, 1 << 30, MOST - 1, MOST];
        let ns = ns.iter().flat_map(|by| ns.iter().map(move |of| (*by, *of)));
        for (x, (by, of)) in xs.iter().flat_map(|x| ns.clone().map(move |n| (*x, n))) {
            let ratio = Ratio::new(by, of);
            let product = u128::from(x) * u128::from(by);
            let down = product / u128::from(of);
            let nearest = (product + u128::from(of / 2)) / u128::from(of);
            for (own, exact) in [(ratio.of(x), down), (ratio.of_nearest(x), nearest)] {
                let fits = exact < 1 << 63;
                assert!(
                    if fits { u128::from(own) == exact } else { own >> 63 == 1 },
                    "{x}·{by}/{of}"
                );
            }
        }
    }
}
