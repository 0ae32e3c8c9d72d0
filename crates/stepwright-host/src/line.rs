//! A straight line of several axes: orders that begin and end together.
//!
//! The axis with the most steps has the whole speeds and ramps; the others have their share.

use std::fmt;

use stepwright::profile::Unfit;
use stepwright::{Accel, OutOfRange};
use stepwright_protocol::{AxisId, Distance, MAX_AXES, Order, Ramp, Travel};

use crate::course::Course;

/// Why a line has no orders.
#[derive(Debug)]
pub enum NoLine {
    /// The order of the whole line can't be divided.
    Whole(Unfit),
    /// The share of this axis can't be sent on the serial line.
    Share(AxisId, OutOfRange),
}

impl fmt::Display for NoLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoLine::Whole(why) => why.fmt(f),
            NoLine::Share(axis, why) => write!(f, "axis {}: its share of the {why}", axis.number()),
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
        .map(|(axis, order)| Ok((axis, order.sendable().map_err(|why| NoLine::Share(axis, why))?)))
        .collect()
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
