//! A straight line of several axes, within the limits of each.

use super::moves::distance;
use super::{Axis, AxisSet, MoveError, Steppers};
use crate::control::Control;
use crate::order::Travel;

impl<E: Control, const N: usize, const Q: usize> Steppers<'_, E, N, Q> {
    /// Moves axes at rest along a straight line to these positions, in steps: they begin together
    /// and end together. Axes that are not named stay where they are. The line is as fast as the
    /// limits of its axes allow.
    ///
    /// An axis with few steps in a long line ends a little before or after the others, because its
    /// share of the speed and of the acceleration is rounded to 0.001 steps/s and steps/s². At a
    /// share of v steps/s the difference is at most some 0.0005/v of the line's time: 0.5 % at 0.1
    /// steps/s. At 600 steps/s and 1,000 steps/s², X with 90,000 steps ends after 150.6 s, an axis
    /// with 2 steps after 143.5 s and one with 60 after 150.7 s. A single step is made at the
    /// beginning.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.move_line_to([(Axis::X, 20_000), (Axis::Y, -6_666)])?;
    /// assert_eq!(motors.distance_to_go(Axis::Y), Some(-6_666));
    /// # Ok::<(), MoveError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`move_to`](Steppers::move_to), for any of the axes, and [`MoveError::NamedTwice`].
    /// Then no axis moves.
    ///
    /// [`Unfit::TooSlow`](crate::profile::Unfit::TooSlow) also if an axis has so few steps that two
    /// of them would be more than 2³² ticks apart, 268 s on an Uno: 2 steps beside 140,000 at 600
    /// steps/s. Where the limits do not allow a faster line, split it into several lines, or move
    /// that axis by itself.
    pub fn move_line_to(
        &mut self,
        ends: impl IntoIterator<Item = (Axis<N>, i64)>,
    ) -> Result<(), MoveError> {
        let (mut way, mut named) = ([0; N], AxisSet::NONE);
        for (axis, end) in ends {
            if named.contains(axis) {
                return Err(MoveError::NamedTwice);
            }
            named |= axis;
            self.must_rest(axis)?;
            let from = self.position(axis).ok_or(MoveError::PositionUnknown)?;
            if let Some(steps) = way.get_mut(axis.index()) {
                *steps = distance(from, end)?;
            }
        }
        let pulses = way.map(i32::unsigned_abs);
        let furthest = pulses.into_iter().max().unwrap_or(0);
        // A single step is made at the beginning and does not slow the line down.
        let ways = self.axes.iter().map(|own| &own.limits).zip(pulses);
        let ways = ways.filter(|(_, pulses)| *pulses > 1 || *pulses == furthest);
        let limits = ways.map(|(limits, pulses)| limits.stretched(pulses, furthest));
        let Some(limits) = limits.reduce(|all, one| all.stricter(&one)) else { return Ok(()) };
        let whole = limits.order(Travel::By(0));
        let mut orders = [None; N];
        for (axis, order) in whole.split_line(way)? {
            let axis = usize::from(axis);
            if let (Some(place), Some(own)) = (orders.get_mut(axis), self.axes.get(axis)) {
                // A single step has no share of the line: it becomes a move of its own.
                let single = order.travel == Travel::By(1) || order.travel == Travel::By(-1);
                *place = Some(if single { own.limits.order(order.travel) } else { order });
            }
        }
        self.begin(Axis::all().zip(orders).filter_map(|(axis, order)| Some((axis, order?))))
    }
}
