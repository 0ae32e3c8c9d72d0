//! A straight line of several axes: orders that begin and end together.
//!
//! The axis with the most steps has the whole speeds and ramps; the others have their share. The serial
//! line carries start speeds, accelerations and jerks in whole steps, so the ramps of a small share differ
//! from the line's. The top speed, in thousandths, makes up for that: the axes still end together.

use std::fmt;

use stepwright::profile::Unfit;
use stepwright::{Accel, OutOfRange, Speed};
use stepwright_protocol::{AxisId, Distance, MAX_AXES, Order, Ramp, RampSteps, Travel};

use crate::course::Course;

/// The axes of a line end together if they end within this time, in seconds.
pub const NOTABLE: f64 = 0.000_5;

/// The axes of a line are on it if they leave it by no more steps than this.
pub const NEAR: f64 = 2.0;

/// Why a line has no orders.
#[derive(Debug)]
pub enum NoLine {
    /// The order of the whole line can't be divided.
    Whole(Unfit),
    /// The share of an axis can't be sent on the serial line.
    Share {
        /// The axis.
        axis: AxisId,
        /// The value that is out of range.
        why: OutOfRange,
        /// The least such value of the whole line whose share can be sent, in whole steps.
        least: u32,
    },
}

impl fmt::Display for NoLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoLine::Whole(why) => why.fmt(f),
            NoLine::Share { axis, why, .. } => {
                write!(f, "axis {}: its share of the {why}", axis.number())
            }
        }
    }
}

impl std::error::Error for NoLine {}

/// The axis with the most steps, and its steps. `steps` are those of axis 1, 2, …
pub fn furthest(steps: &[Distance]) -> Option<(AxisId, Distance)> {
    let each = AxisId::first(steps.len() as u8).zip(steps.iter().copied());
    each.max_by_key(|(axis, way)| (way.get().unsigned_abs(), !axis.number()))
}

/// The order of each axis that moves, as the serial line can send it, from the order of the axis with the most
/// steps. `steps` are those of axis 1, 2, …
///
/// # Errors
/// [`NoLine`]
pub fn shares(
    (lead, leading): (AxisId, Order),
    steps: &[Distance],
) -> Result<Vec<(AxisId, Order)>, NoLine> {
    let mut ways = [0; MAX_AXES as usize];
    for (way, steps) in ways.iter_mut().zip(steps) {
        *way = steps.get();
    }
    let whole = stepwright::Order::from(leading);
    let orders = whole.split_line(ways).map_err(NoLine::Whole)?;
    let way = |axis: AxisId| steps.get(axis.index()).map_or(0, |way| way.get().unsigned_abs());
    let unsayable = |axis, why| {
        let (most, own) = (way(lead).saturating_sub(1), way(axis).saturating_sub(1).max(1));
        NoLine::Share { axis, why, least: most.div_ceil(own) }
    };
    let leading = leading.sendable().map_err(|why| unsayable(lead, why))?;
    let end = Course::of(&leading.into()).map(|course| course.duration());
    orders
        .filter_map(|(axis, order)| {
            let (axis, way) = (AxisId::numbered(axis + 1)?, *steps.get(usize::from(axis))?);
            if axis == lead {
                return Some((axis, leading));
            }
            let ramp = |ramp| match order.accel(ramp) {
                // Without a ramp the slope does not matter, but the line needs one.
                _ if order.top <= order.start => Some(Ramp::Accel(Accel::clamped(1))),
                slope => slope.ok().map(Ramp::Accel),
            };
            let (up, down) = (ramp(order.up)?, ramp(order.down)?);
            let travel = Travel::By(way);
            let (start, top, jerk) = (order.start, order.top, order.jerk);
            Some((axis, Order { start, top, up, down, jerk, travel }))
        })
        .map(|(axis, share)| {
            let sent = if axis == lead { Ok(share) } else { by_length(share).sendable() };
            let sent = sent.map_err(|why| unsayable(axis, why))?;
            Ok((axis, end.map_or(sent, |end| ending(sent, leading.top, end))))
        })
        .collect()
}

/// A share of a line with its ramps counted in steps, if that is more exact than whole steps/s².
fn by_length(share: Order) -> Order {
    let (Ramp::Accel(accel), true) = (share.up, share.up == share.down) else { return share };
    let squared = |v: Speed| u64::from(v.millisteps()).pow(2);
    let rise = squared(share.top).saturating_sub(squared(share.start));
    let accel = accel.millisteps();
    let steps = rise as f64 / 2e3 / accel as f64;
    let whole = |value: f64| value.round().max(1.0);
    let error = |value: f64| (whole(value) - value).abs() / value;
    let length = RampSteps::new(whole(steps) as u32);
    match length.filter(|_| error(steps) < error(accel as f64 / 1e3)) {
        Some(length) => Order { up: Ramp::Steps(length), down: Ramp::Steps(length), ..share },
        None => share,
    }
}

/// The order with the top speed, up to `most`, by which it takes `end` seconds, if its own differs.
fn ending(order: Order, most: Speed, end: f64) -> Order {
    let with = |top| Speed::from_millisteps(top).map_or(order, |top| Order { top, ..order });
    let own = late(order, end).abs();
    let is_one = matches!(order.travel, Travel::By(way) if way.get().unsigned_abs() < 2);
    if is_one || own < NOTABLE {
        return order;
    }
    let (mut low, mut high) = (1, most.millisteps());
    while low < high {
        let middle = low + (high - low) / 2;
        (low, high) =
            if late(with(middle), end) > 0.0 { (middle + 1, high) } else { (low, middle) };
    }
    let mut best = (own, order);
    for top in [low.saturating_sub(1), low] {
        let other = with(top);
        let off = late(other, end).abs();
        if off < best.0 {
            best = (off, other);
        }
    }
    best.1
}

/// How many seconds after `end` an order ends.
fn late(order: Order, end: f64) -> f64 {
    Course::of(&order.into()).map_or(f64::INFINITY, |course| course.duration() - end)
}

/// Seconds between the end of the first axis and that of the last.
pub fn apart(orders: &[(AxisId, Order)]) -> f64 {
    let ends: Vec<f64> = orders
        .iter()
        .filter_map(|(_, order)| Course::of(&(*order).into()))
        .filter(|course| course.pulses() > 1)
        .map(|course| course.duration())
        .collect();
    let most = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = ends.iter().copied().fold(f64::INFINITY, f64::min);
    (most - least).max(0.0)
}

/// How many steps an axis leaves the line by, at most, at 32 of its pulses.
pub fn off(orders: &[(AxisId, Order)]) -> f64 {
    let courses = orders.iter().filter_map(|(_, order)| Course::of(&(*order).into()));
    let courses: Vec<_> = courses.filter(|course| course.pulses() > 1).collect();
    let Some(lead) = courses.iter().max_by_key(|course| course.pulses()) else { return 0.0 };
    let off = |course: &Course, n: u32| {
        let (time, last) = (course.seconds(n), lead.pulses() - 1);
        let (mut place, mut after) = (0, last);
        while place < after {
            let middle = place + (after - place) / 2;
            let is_before = lead.seconds(middle) < time;
            (place, after) = if is_before { (middle + 1, after) } else { (place, middle) };
        }
        let share = f64::from(course.pulses() - 1) / f64::from(last);
        (f64::from(place) * share - f64::from(n)).abs()
    };
    let of = |course| (1..=32).map(move |part| off(course, pulse(course, part)));
    courses.iter().flat_map(of).fold(0.0, f64::max)
}

/// The pulse after this many 32nds of a course.
fn pulse(course: &Course, part: u32) -> u32 {
    (u64::from(course.pulses() - 1) * u64::from(part) / 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(
        accel: u32,
        top: u32,
        start: u32,
        jerk: Option<u32>,
        steps: &[i32],
    ) -> Vec<(AxisId, Order)> {
        let steps: Vec<_> = steps.iter().map(|steps| Distance::new(*steps)).collect();
        let (lead, way) = furthest(&steps).unwrap();
        let ramp = Ramp::Accel(Accel::from_steps(accel).unwrap());
        let speed = |v| Speed::from_steps(v).unwrap();
        let jerk = jerk.map(|jerk| stepwright::Jerk::from_steps(jerk.into()).unwrap());
        let (start, top) = (speed(start), speed(top));
        let order = Order { start, top, up: ramp, down: ramp, jerk, travel: Travel::By(way) };
        shares((lead, order), &steps).unwrap()
    }

    /// Shares of accelerations that are nowhere near a whole number.
    #[test]
    fn axes_with_rounded_ramps_end_together() {
        for (accel, top, start, steps) in [
            (100, 1000, 50, &[10_000, 51][..]),
            (300, 1000, 50, &[20_000, 2_000, 20]),
            (2_494, 1000, 50, &[20_000, -20]),
            (5_000, 10_000, 0, &[100_000, 30, 7]),
            (100, 1_000, 50, &[100_000, 10]),
            (5_000, 3_000, 50, &[20_000, 3, 7]),
            (700, 40_000, 0, &[1_000_000, 999, 20]),
        ] {
            for jerk in [None, Some(90_000)] {
                // Where the share of the jerk can be sent.
                if jerk.is_some() && steps.iter().any(|n: &i32| n.unsigned_abs() < 40) {
                    continue;
                }
                let orders = line(accel, top, start, jerk, steps);
                let end = |order: Order| Course::of(&order.into()).unwrap().duration();
                for (_, order) in &orders {
                    let late = end(*order) - end(orders[0].1);
                    // A fiftieth of a second, or of a step: the top speed is in thousandths.
                    let most = f64::max(0.02, 20.0 / f64::from(order.top.millisteps()));
                    assert!(late.abs() < most, "{steps:?} {jerk:?}: {late} {orders:#?}");
                }
            }
        }
    }

    /// Every axis is on the line all the time, within a step.
    #[test]
    fn axes_with_rounded_ramps_stay_on_the_line() {
        for (accel, top, steps) in
            [(100, 2_000, [10_000, 51]), (300, 2_000, [20_000, 2_000]), (37, 1_000, [30_000, 911])]
        {
            let orders = line(accel, top, 0, None, &steps);
            assert!(off(&orders) < 1.0, "{steps:?}: {} steps off", off(&orders));
        }
        // No ramp in whole steps/s² or in up to 999 steps has this share.
        let orders = line(1, 10_000, 0, None, &[1_000_000, 900_000]);
        assert!(off(&orders) > 100.0, "{}", off(&orders));
    }

    #[test]
    fn a_line_whose_shares_are_exact_keeps_them() {
        let orders = line(8_000, 1_000, 0, None, &[4_001, -2_001]);
        let (_, half) = orders[1];
        assert_eq!((half.top.millisteps(), half.up), (500_000, Ramp::Accel(Accel::clamped(4_000))));
    }
}
