//! An axis whose moves can be awaited.

use core::future::poll_fn;
use core::task::Poll;

use stepwright::{Axis, AxisLimits, ByNews, Control, MoveError, Speed, Steppers};

use crate::motors::Motors;
use crate::outcome::Outcome;

/// An axis of [`Motors`].
///
/// A move begins when its future is first polled, and has the axis to itself until that has ended or
/// is dropped: another move is refused as [busy](stepwright::Refusal::Busy) until then. **A future that
/// is dropped on the way brakes**: the axis comes to rest along its ramp, behind what is planned
/// already, and its position stays known. So the losers of a `select` stop, and so does what a task
/// was doing that has ended. A move of an axis that brakes so begins when it rests.
///
/// | to | call |
/// | --- | --- |
/// | move and wait for the end | [`move_to`](AsyncAxis::move_to), [`move_by`](AsyncAxis::move_by) |
/// | turn until something happens | [`run`](AsyncAxis::run), in a `select` |
/// | change a move that is awaited, by another handle | [`retarget`](AsyncAxis::retarget), [`set_top_speed`](AsyncAxis::set_top_speed) |
/// | stop and wait for rest | [`stop`](AsyncAxis::stop), [`rest`](AsyncAxis::rest) |
pub struct AsyncAxis<'a, 'q, E, const N: usize, const Q: usize = 8> {
    pub(crate) motors: &'a Motors<'q, E, N, Q>,
    pub(crate) axis: Axis<N>,
}

/// A move that a future owns.
struct Owned<'a, 'q, E: Control, const N: usize, const Q: usize> {
    motors: &'a Motors<'q, E, N, Q>,
    axis: Axis<N>,
}

impl<E: Control, const N: usize, const Q: usize> Drop for Owned<'_, '_, E, N, Q> {
    fn drop(&mut self) {
        self.motors.release(self.axis);
    }
}

type Planned<'q, E, const N: usize, const Q: usize> = Steppers<'q, ByNews<E>, N, Q>;

impl<E: Control, const N: usize, const Q: usize> AsyncAxis<'_, '_, E, N, Q> {
    /// Sets the limits of the axis: they hold for moves that begin from now on.
    pub fn set_limits(&self, limits: AxisLimits) {
        self.motors.look(|steppers| steppers.set_limits(self.axis, limits));
    }

    /// The limits of the axis.
    pub fn limits(&self) -> AxisLimits {
        self.motors.look(|steppers| steppers.limits(self.axis)).unwrap_or_default()
    }

    /// The position in steps, also on the way; `None` where it is not known.
    pub fn position(&self) -> Option<i64> {
        self.motors.look(|steppers| steppers.position(self.axis)).flatten()
    }

    /// Says that the axis, which rests, stands at this position.
    ///
    /// # Errors
    /// [`Refusal::Busy`](stepwright::Refusal::Busy) while it moves.
    pub fn set_position(&self, position: i64) -> Result<(), MoveError> {
        self.motors.say(|steppers| steppers.set_position(self.axis, position))
    }

    /// Forgets the position: something else may have turned the motor.
    pub fn mark_unknown(&self) {
        self.motors.look(|steppers| steppers.mark_unknown(self.axis));
    }

    /// Whether the axis moves, or is about to.
    pub fn is_moving(&self) -> bool {
        self.motors.look(|steppers| steppers.is_moving(self.axis)).unwrap_or(true)
    }

    /// Moves to a position, in steps.
    ///
    /// # Errors
    /// Those of [`Steppers::move_to`], and [`Refusal::Busy`](stepwright::Refusal::Busy) while another
    /// future has the axis. Nothing moves.
    pub fn move_to(&mut self, position: i64) -> impl Future<Output = Result<Outcome, MoveError>> {
        let axis = self.axis;
        self.carry_out(move |_| Some(position), move |steppers| steppers.move_to(axis, position))
    }

    /// Moves by this many steps, forward or backward. The position need not be known; then the move
    /// ends as [`Outcome::Uncertain`].
    ///
    /// # Errors
    /// As of [`move_to`](AsyncAxis::move_to), but for the position.
    pub fn move_by(&mut self, steps: i32) -> impl Future<Output = Result<Outcome, MoveError>> {
        let axis = self.axis;
        let goal = move |steppers: &Planned<'_, E, N, Q>| {
            steppers.position(axis)?.checked_add(steps.into())
        };
        self.carry_out(goal, move |steppers| steppers.move_by(axis, steps))
    }

    /// Turns at this speed in steps/s, backward below 0, until it is stopped: by another handle, or by
    /// the drop of this future. At 0 it is at its end already.
    ///
    /// # Errors
    /// Those of [`Steppers::run`], and [`Refusal::Busy`](stepwright::Refusal::Busy) while another future
    /// has the axis.
    pub fn run(
        &mut self,
        steps_per_second: i32,
    ) -> impl Future<Output = Result<Outcome, MoveError>> {
        let axis = self.axis;
        self.carry_out(|_| None, move |steppers| steppers.run(axis, steps_per_second))
    }

    /// Begins a move to a goal, and waits for its end.
    fn carry_out(
        &self,
        goal: impl FnOnce(&Planned<'_, E, N, Q>) -> Option<i64>,
        order: impl FnOnce(&mut Planned<'_, E, N, Q>) -> Result<(), MoveError>,
    ) -> impl Future<Output = Result<Outcome, MoveError>> {
        let AsyncAxis { motors, axis } = *self;
        let (mut order, mut owned) = (Some((goal, order)), None);
        poll_fn(move |context| {
            if order.is_some() && motors.poll_braked(axis, context).is_pending() {
                return Poll::Pending;
            }
            if let Some((goal, order)) = order.take() {
                if let Err(error) = motors.begin(axis, goal, order) {
                    return Poll::Ready(Err(error));
                }
                owned = Some(Owned { motors, axis });
            }
            if owned.is_none() {
                // It has ended: nothing more comes.
                return Poll::Pending;
            }
            let ended = motors.poll_end(axis, context);
            if ended.is_ready() {
                owned = None;
            }
            ended.map(Ok)
        })
    }

    /// Brakes along the ramp, and waits for rest: where that is; `None` if that is not known. A move
    /// that is awaited ends as [`Outcome::Stopped`].
    pub fn stop(&mut self) -> impl Future<Output = Option<i64>> {
        let AsyncAxis { motors, axis } = *self;
        let mut told = false;
        poll_fn(move |context| {
            if !told {
                told = true;
                let brake = |steppers: &mut Planned<'_, E, N, Q>| {
                    steppers.stop(axis);
                    Ok(())
                };
                // Refused within `with` alone, where nobody awaits.
                let _ = motors.say(brake);
            }
            motors.poll_rest(axis, context)
        })
    }

    /// Waits until the axis rests, whoever moves it: where that is; `None` if that is not known.
    ///
    /// Of more than four tasks that wait for one axis, the one that moves it among them, some wake each
    /// other until it rests.
    pub fn rest(&self) -> impl Future<Output = Option<i64>> {
        let AsyncAxis { motors, axis } = *self;
        poll_fn(move |context| motors.poll_rest(axis, context))
    }

    /// Gives a move that is under way, or a run, another target, in steps: its future waits for that.
    ///
    /// # Errors
    /// Those of [`Steppers::retarget`]. The move goes on as it was.
    pub fn retarget(&self, position: i64) -> Result<(), MoveError> {
        self.motors.retarget(self.axis, position)
    }

    /// Gives a move that is under way, or a run, another top speed.
    ///
    /// # Errors
    /// Those of [`Steppers::set_top_speed`]. The move goes on as it
    /// was.
    pub fn set_top_speed(&self, top: Speed) -> Result<(), MoveError> {
        self.motors.say(|steppers| steppers.set_top_speed(self.axis, top))
    }
}
