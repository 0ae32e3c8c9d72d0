//! Moves of one axis, within its limits.

use super::{Axis, AxisLimits, MoveError, Steppers};
use crate::control::Control;
use crate::order::{Change, Order, Refusal, Travel};
use crate::profile::Unfit;
use crate::units::{Accel, Speed};

impl<E: Control, const N: usize, const Q: usize> Steppers<'_, E, N, Q> {
    /// Sets the limits of an axis. They apply to moves that begin from now on.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// for axis in Axis::all() {
    ///     motors.set_limits(axis, AxisLimits::DEFAULT);
    /// }
    /// assert_eq!(motors.limits(Axis::X), AxisLimits::DEFAULT);
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn set_limits(&mut self, axis: Axis<N>, limits: AxisLimits) {
        if let Some(own) = self.axes.get_mut(axis.index()) {
            own.limits = limits;
        }
    }

    /// The limits of an axis.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// let limits = motors.limits(Axis::Y).deceleration(stepwright::Accel::from_steps(5_000)?);
    /// motors.set_limits(Axis::Y, limits);
    /// assert_eq!(motors.limits(Axis::Y), limits);
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn limits(&self, axis: Axis<N>) -> AxisLimits {
        self.axes.get(axis.index()).map(|own| own.limits).unwrap_or_default()
    }

    /// Moves an axis at rest to a position, in steps. If the axis is there already, the move ends
    /// at once. After a slow ramp or a long line the axis rests first: see
    /// [`count_rest`](Steppers::count_rest).
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.move_to(Axis::X, -2_000)?;
    /// assert!(motors.move_to(Axis::X, 0).is_err(), "it moves");
    /// # Ok::<(), MoveError>(())
    /// ```
    ///
    /// # Errors
    /// [`MoveError::PositionUnknown`]; [`Refusal::Busy`] while the axis moves, see
    /// [`retarget`](Steppers::retarget); [`Unfit::TooLong`] if the position is 2³¹ steps or more
    /// away; or what the board or the timer can't do.
    pub fn move_to(&mut self, axis: Axis<N>, position: i64) -> Result<(), MoveError> {
        self.must_rest(axis)?;
        let from = self.position(axis).ok_or(MoveError::PositionUnknown)?;
        let steps = distance(from, position)?;
        self.travel(axis, self.limits(axis).order(Travel::By(steps)))
    }

    /// Moves an axis at rest by this many steps, forward or backward. Its position may be unknown.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.move_by(Axis::Y, 200)?;
    /// assert!(motors.is_moving(Axis::Y));
    /// # Ok::<(), MoveError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`move_to`](Steppers::move_to), except for the position.
    pub fn move_by(&mut self, axis: Axis<N>, steps: i32) -> Result<(), MoveError> {
        self.must_rest(axis)?;
        // Neither the distance nor the target may exceed the range of the counts.
        self.origin_now(axis).checked_add(steps.into()).ok_or(Unfit::TooLong)?;
        if steps == i32::MIN {
            return Err(Unfit::TooLong.into());
        }
        self.travel(axis, self.limits(axis).order(Travel::By(steps)))
    }

    /// Turns an axis at this speed until it is stopped: forward if the speed is above 0, backward
    /// if it is below. An axis that already runs in this direction changes to the new speed. A
    /// speed of 0 stops the axis.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.run(Axis::X, -300)?;
    /// motors.run(Axis::X, -400)?; // faster, the same way
    /// assert!(motors.run(Axis::X, 400).is_err(), "stop it first");
    /// assert!(motors.run(Axis::Y, 501).is_err(), "above its limit");
    /// # Ok::<(), MoveError>(())
    /// ```
    ///
    /// # Errors
    /// [`MoveError::AboveLimit`] above the axis's limit; [`Refusal::Busy`] while the axis runs in
    /// the other direction or moves to a target; or what the board or the timer can't do.
    pub fn run(&mut self, axis: Axis<N>, steps_per_second: i32) -> Result<(), MoveError> {
        if steps_per_second == 0 {
            self.stop(axis);
            return Ok(());
        }
        let (top, forward) =
            (Speed::from_steps(steps_per_second.unsigned_abs())?, steps_per_second > 0);
        let limits = self.limits(axis);
        if top > limits.max_speed {
            return Err(MoveError::AboveLimit { max: limits.max_speed });
        }
        let number = axis.number();
        if self.motors.group.is_endless(number) && self.motors.is_forward(axis) == forward {
            return self.set_top_speed(axis, top);
        }
        self.must_rest(axis)?;
        self.travel(axis, Order { top, ..limits.order(Travel::Endless(forward)) })
    }

    /// Gives a moving axis, or one that runs, another target: a position in steps. If the axis
    /// cannot reach the target without overshooting, it comes back to it. The axis is busy all the
    /// while and keeps the limits with which the move began; along a line, its share of them.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.move_to(Axis::X, 2_000)?;
    /// motors.retarget(Axis::X, 1_500)?;
    /// assert_eq!(motors.distance_to_go(Axis::X), Some(1_500));
    /// # Ok::<(), MoveError>(())
    /// ```
    ///
    /// # Errors
    /// [`Refusal::Resting`] at rest; [`MoveError::PositionUnknown`]; [`Unfit::TooLong`] if the
    /// target is 2³¹ steps or more from where the move began. Then the move continues unchanged.
    pub fn retarget(&mut self, axis: Axis<N>, position: i64) -> Result<(), MoveError> {
        if !self.is_moving(axis) {
            return Err(Refusal::Resting.into());
        }
        self.position(axis).ok_or(MoveError::PositionUnknown)?;
        self.change(axis, Change::Target(distance(self.origin(axis), position)?))
    }

    /// Gives a moving axis, or one that runs, another top speed, within the limit of the axis. The
    /// axis ramps to that speed with its present acceleration or deceleration and still ends
    /// exactly on its target. The limits and later moves stay unchanged; an axis of a line leaves
    /// the line.
    ///
    /// The change takes effect after the steps that are already planned: some 24 ms, or the present
    /// step and the next one, if they take longer. So do those of the next two methods.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// use stepwright::Speed;
    /// motors.move_to(Axis::X, 2_000)?; // at most 500 steps/s
    /// motors.set_top_speed(Axis::X, Speed::of::<200>())?;
    /// assert!(motors.set_top_speed(Axis::X, Speed::of::<501>()).is_err());
    /// # Ok::<(), MoveError>(())
    /// ```
    ///
    /// # Errors
    /// [`MoveError::AboveLimit`]; [`Refusal::Resting`] at rest; [`Unfit::BelowStart`] below the
    /// start speed; or what the board can't do beside the other moving axes. Then the move
    /// continues unchanged.
    pub fn set_top_speed(&mut self, axis: Axis<N>, top: Speed) -> Result<(), MoveError> {
        let max = self.limits(axis).max_speed;
        if top > max {
            return Err(MoveError::AboveLimit { max });
        }
        self.change(axis, Change::Top(top))
    }

    /// Gives a moving axis, or one that runs, another acceleration, within the limit of the axis.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// use stepwright::Accel;
    /// motors.run(Axis::X, 500)?; // at 1,000 steps/s²
    /// motors.set_acceleration(Axis::X, Accel::of::<300>())?;
    /// # Ok::<(), MoveError>(())
    /// ```
    ///
    /// # Errors
    /// [`MoveError::TooSteep`]; [`Refusal::Resting`] at rest; or what the board can't do. Then the
    /// move continues unchanged.
    pub fn set_acceleration(&mut self, axis: Axis<N>, accel: Accel) -> Result<(), MoveError> {
        let max = self.limits(axis).acceleration;
        if accel > max {
            return Err(MoveError::TooSteep { limit: "acceleration", max });
        }
        self.change(axis, Change::Accel(accel))
    }

    /// Gives a moving axis, or one that runs, another deceleration, within the limit of the axis.
    /// With a lower one the axis may overshoot its target and come back.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// use stepwright::Accel;
    /// motors.move_to(Axis::X, 2_000)?; // at 1,000 steps/s²
    /// motors.set_deceleration(Axis::X, Accel::of::<300>())?;
    /// # Ok::<(), MoveError>(())
    /// ```
    ///
    /// # Errors
    /// [`MoveError::TooSteep`]; [`Refusal::Resting`] at rest; or what the board can't do. Then the
    /// move continues unchanged.
    pub fn set_deceleration(&mut self, axis: Axis<N>, decel: Accel) -> Result<(), MoveError> {
        let max = self.limits(axis).deceleration;
        if decel > max {
            return Err(MoveError::TooSteep { limit: "deceleration", max });
        }
        self.change(axis, Change::Decel(decel))
    }

    /// The steps left to the target of a move, positive forward; during a stop, to where the axis
    /// will come to rest; 0 at rest. `None` for a run, which has no target.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.move_by(Axis::X, 200)?;
    /// assert_eq!(motors.distance_to_go(Axis::X), Some(200));
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn distance_to_go(&self, axis: Axis<N>) -> Option<i64> {
        if !self.is_moving(axis) {
            return Some(0);
        }
        let target = self.motors.group.target(axis.number())?;
        let end = self.origin(axis).wrapping_add(target.into());
        Some(end.wrapping_sub(self.motors.engine.position(axis.number())))
    }

    fn change(&mut self, axis: Axis<N>, change: Change) -> Result<(), MoveError> {
        Ok(self.motors.change(axis, change)?)
    }

    /// Starts a travel of an axis at rest.
    fn travel(&mut self, axis: Axis<N>, order: Order) -> Result<(), MoveError> {
        self.note_origins();
        Ok(self.motors.start([(axis, order)])?)
    }

    /// Records the positions of the axes at rest, where their next travels begin.
    pub(super) fn note_origins(&mut self) {
        for axis in Axis::all() {
            if self.is_moving(axis) {
                continue;
            }
            let now = self.origin_now(axis);
            if let Some(own) = self.axes.get_mut(axis.index()) {
                own.origin = now;
            }
        }
    }

    /// The step count of an axis at rest, whether its position is known or not.
    fn origin_now(&self, axis: Axis<N>) -> i64 {
        self.motors.engine.position(axis.number())
    }

    fn origin(&self, axis: Axis<N>) -> i64 {
        self.axes.get(axis.index()).map_or(0, |own| own.origin)
    }
}

/// The steps from one position to another, fewer than 2³¹.
pub(super) fn distance(from: i64, to: i64) -> Result<i32, Unfit> {
    let steps = to.checked_sub(from).and_then(|steps| i32::try_from(steps).ok());
    steps.filter(|steps| *steps != i32::MIN).ok_or(Unfit::TooLong)
}
