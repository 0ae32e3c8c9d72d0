//! A straight line of several axes, within the limits of each.

use super::moves::distance;
use super::{Axis, AxisLimits, AxisSet, MoveError, Steppers};
use crate::control::Control;
use crate::order::Travel;
use crate::ordered::OrderedMotors;

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
    /// beginning. After such a line that axis rests for as long as one of its steps took: see
    /// [`count_rest`](Steppers::count_rest).
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
        self.line(&way)
    }

    /// Starts a line of these steps for each axis.
    #[inline(never)]
    fn line(&mut self, way: &[i32; N]) -> Result<(), MoveError> {
        let furthest = way.iter().map(|steps| steps.unsigned_abs()).max().unwrap_or(0);
        let mut limits = AxisLimits::NONE;
        for (own, steps) in self.axes.iter().zip(way) {
            let pulses = steps.unsigned_abs();
            // A single step is made at the beginning and does not slow the line down.
            if pulses > 1 || pulses == furthest {
                limits.tighten(&own.limits, pulses, furthest);
            }
        }
        self.note_origins();
        let mut result = Ok(());
        for (axis, steps) in Axis::all().zip(way) {
            let travel = Travel::By(*steps);
            let order = match steps {
                0 => continue,
                // A single step has no share of the line: it becomes a move of its own.
                1 | -1 => self.limits(axis).order(travel),
                _ => {
                    let whole = limits.order(travel);
                    whole.part_of_line(*steps, furthest).unwrap_or(whole)
                }
            };
            result = self.motors.prepare(axis, &order);
            if result.is_err() {
                break;
            }
        }
        let OrderedMotors { group, engine } = &mut self.motors;
        Ok(group.finish(engine, result)?)
    }
}
