//! An axis with moves to await.

use core::future::poll_fn;
use core::task::Poll;

use stepwright::{Axis, AxisLimits, ByNews, Control, MoveError, Speed, Steppers};

use crate::motors::Motors;
use crate::outcome::Outcome;

/// An axis of [`Motors`].
///
/// A move begins when its future is first polled. That future owns the axis until it rests or the
/// future is dropped: another move is refused as [busy](stepwright::Refusal::Busy) until then, or
/// while two futures that were kept have not been polled since the ends of their moves. **A
/// future that is dropped on the way brakes its axis**: the axis comes to rest along its ramp,
/// after the part that is planned already, and its position stays known. So the losers of a
/// `select` stop, and so do the moves of a task that ends. The next move of such a braking axis
/// begins when the axis rests.
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

/// The ownership of a move by its future.
struct Owned<'a, 'q, E: Control, const N: usize, const Q: usize> {
    motors: &'a Motors<'q, E, N, Q>,
    axis: Axis<N>,
    seat: usize,
}

impl<E: Control, const N: usize, const Q: usize> Drop for Owned<'_, '_, E, N, Q> {
    fn drop(&mut self) {
        self.motors.release(self.axis, self.seat);
    }
}

type Planned<'q, E, const N: usize, const Q: usize> = Steppers<'q, ByNews<E>, N, Q>;

impl<E: Control, const N: usize, const Q: usize> AsyncAxis<'_, '_, E, N, Q> {
    /// Sets the limits of the axis, for moves that begin from now on.
    pub fn set_limits(&self, limits: AxisLimits) {
        self.motors.look(|steppers| steppers.set_limits(self.axis, limits));
    }

    /// The limits of the axis.
    pub fn limits(&self) -> AxisLimits {
        self.motors.look(|steppers| steppers.limits(self.axis)).unwrap_or_default()
    }

    /// The position in steps, also during a move; `None` if it is unknown.
    pub fn position(&self) -> Option<i64> {
        self.motors.look(|steppers| steppers.position(self.axis)).flatten()
    }

    /// Sets the position of the resting axis.
    ///
    /// # Errors
    /// [`Refusal::Busy`](stepwright::Refusal::Busy) while it moves.
    pub fn set_position(&self, position: i64) -> Result<(), MoveError> {
        self.motors.say(|steppers| steppers.set_position(self.axis, position))
    }

    /// Makes the position unknown: the motor may have been turned from outside.
    pub fn mark_unknown(&self) {
        self.motors.look(|steppers| steppers.mark_unknown(self.axis));
    }

    /// Whether the axis moves or is about to.
    pub fn is_moving(&self) -> bool {
        self.motors.look(|steppers| steppers.is_moving(self.axis)).unwrap_or(true)
    }

    /// Moves to a position, in steps.
    ///
    /// # Errors
    /// Those of [`Steppers::move_to`], and [`Refusal::Busy`](stepwright::Refusal::Busy) while
    /// another future owns the axis. Nothing moves.
    pub fn move_to(&mut self, position: i64) -> impl Future<Output = Result<Outcome, MoveError>> {
        let axis = self.axis;
        self.carry_out(move |_| Some(position), move |steppers| steppers.move_to(axis, position))
    }

    /// Moves by this many steps, forward or backward. The position may be unknown; then the move
    /// ends as [`Outcome::Uncertain`].
    ///
    /// # Errors
    /// Those of [`move_to`](AsyncAxis::move_to), except that for an unknown position.
    pub fn move_by(&mut self, steps: i32) -> impl Future<Output = Result<Outcome, MoveError>> {
        let axis = self.axis;
        let goal = move |steppers: &Planned<'_, E, N, Q>| {
            steppers.position(axis)?.checked_add(steps.into())
        };
        self.carry_out(goal, move |steppers| steppers.move_by(axis, steps))
    }

    /// Turns at this speed in steps/s, backward if negative, until it is stopped by another handle,
    /// or its future is dropped. A speed of 0 ends at once.
    ///
    /// # Errors
    /// Those of [`Steppers::run`], and [`Refusal::Busy`](stepwright::Refusal::Busy) while another
    /// future owns the axis.
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
                match motors.begin(axis, goal, order) {
                    Ok(seat) => owned = Some(Owned { motors, axis, seat }),
                    Err(error) => return Poll::Ready(Err(error)),
                }
            }
            let Some(own) = &owned else {
                // The move has ended already: a finished future stays pending.
                return Poll::Pending;
            };
            let ended = motors.poll_end(axis, own.seat, context);
            if ended.is_ready() {
                owned = None;
            }
            ended.map(Ok)
        })
    }

    /// Brakes along the ramp, and waits for rest. Returns the position, or `None` if it is unknown.
    /// An awaited move ends as [`Outcome::Stopped`].
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
                // Refused only within `with`, where nothing can be awaited.
                let _ = motors.say(brake);
            }
            motors.poll_rest(axis, context)
        })
    }

    /// Waits until the axis rests, whoever moves it. Returns the position, or `None` if it is
    /// unknown.
    ///
    /// If more than four tasks wait for one axis, including the one that moves it, some keep waking
    /// each other until it rests.
    pub fn rest(&self) -> impl Future<Output = Option<i64>> {
        let AsyncAxis { motors, axis } = *self;
        poll_fn(move |context| motors.poll_rest(axis, context))
    }

    /// Gives a move under way, or a run, a new target in steps. Its future waits for the new
    /// target.
    ///
    /// # Errors
    /// Those of [`Steppers::retarget`]. The move goes on unchanged.
    pub fn retarget(&self, position: i64) -> Result<(), MoveError> {
        self.motors.retarget(self.axis, position)
    }

    /// Gives a move under way, or a run, a new top speed.
    ///
    /// # Errors
    /// Those of [`Steppers::set_top_speed`]. The move goes on unchanged.
    pub fn set_top_speed(&self, top: Speed) -> Result<(), MoveError> {
        self.motors.say(|steppers| steppers.set_top_speed(self.axis, top))
    }
}
