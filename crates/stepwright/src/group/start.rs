//! How an order of several axes starts: all of them together, or none.
//!
//! ```text
//!   prepare … prepare ─► commit ─► Pending … Pending ─► Ready(Ok)       all begin
//!                          │ one piece a call      └──► Ready(Err) ─► cancel
//! ```
//!
//! Each call takes a chip no longer than a piece of planning. Between the calls, moving axes are
//! planned as before; they can be stopped or killed. The axes of the order are at rest until the
//! last call, and are not busy.

use core::task::Poll;

use super::{Group, PlannedBoard};
use crate::clamp;
use crate::control::Control;
use crate::order::{Order, Refusal};
use crate::planner::Layout;
use crate::units::Ticks;

impl<const N: usize, const Q: usize> Group<'_, N, Q> {
    /// Starts the axes of these orders together, all or none. They move once their queues are
    /// filled, within a few polls.
    ///
    /// # Errors
    /// [`Refusal`]; then nothing moves.
    pub fn start(
        &mut self,
        engine: &mut impl Control,
        orders: impl IntoIterator<Item = (u8, Order)>,
    ) -> Result<(), Refusal> {
        let mut result = Ok(());
        for (axis, order) in orders {
            result = self.prepare(engine, axis, &order);
            if result.is_err() {
                break;
            }
        }
        self.finish(engine, result)
    }

    /// Starts the prepared orders, or cancels them if one was refused.
    ///
    /// # Errors
    /// [`Refusal`]; then nothing moves.
    pub fn finish(
        &mut self,
        engine: &mut impl Control,
        mut result: Result<(), Refusal>,
    ) -> Result<(), Refusal> {
        while result.is_ok() {
            match self.commit(engine, at_once) {
                Poll::Pending => {}
                Poll::Ready(Ok(())) => return Ok(()),
                Poll::Ready(refused) => result = refused,
            }
        }
        self.cancel();
        result
    }

    /// Takes an order for one axis, as [`start`](Group::start) does for each.
    /// [`commit`](Group::commit) starts all prepared axes together.
    ///
    /// # Errors
    /// [`Refusal`]; then [`cancel`](Group::cancel) the axes that were prepared before.
    #[inline(never)]
    pub fn prepare(
        &mut self,
        engine: &mut impl Control,
        axis: u8,
        order: &Order,
    ) -> Result<(), Refusal> {
        if self.is_busy(engine, axis) {
            return Err(Refusal::Busy);
        }
        let motor = self.motors.get_mut(usize::from(axis)).ok_or(Refusal::NoAxis)?;
        Ok(motor.prepare(order)?)
    }

    /// Does one piece of starting the prepared orders; call it until it is ready. A piece sets up a
    /// part of a travel, checks that the board can step all axes, or begins them together, `wait`
    /// ticks later than it could.
    ///
    /// # Errors
    /// [`Refusal`]; then nothing moves, and [`cancel`](Group::cancel) must be called.
    #[inline(never)]
    pub fn commit(
        &mut self,
        engine: &mut impl Control,
        wait: impl FnOnce() -> Ticks,
    ) -> Poll<Result<(), Refusal>> {
        // The axis of this call: one with the earliest piece.
        let (mut turn, mut piece) = (0, Layout::Nothing);
        let (mut prepared, mut its, mut bit) = (0, 0, 1);
        for (axis, motor) in (0u8..).zip(&self.motors) {
            let own = motor.ordered();
            if own != Layout::Nothing {
                prepared |= bit;
            }
            if own < piece {
                (turn, its, piece) = (axis, bit, own);
            }
            bit <<= 1;
        }
        let index = usize::from(turn);
        match piece {
            Layout::Nothing => return Poll::Ready(Ok(())),
            Layout::Begin => self.begin(turn),
            Layout::Wait => self.wait_for_all(clamp::sum(self.given.board.timing.hold, wait())),
            Layout::Check | Layout::Plan => {
                let PlannedBoard { board, clock, .. } = &self.given;
                let moving = self.moving(engine, prepared);
                let checked = if piece == Layout::Check {
                    board.check_speed(clock, &self.loads, moving, its)
                } else {
                    board.check_ramps(&self.loads, moving, turn)
                };
                if checked.is_err() {
                    return Poll::Ready(checked);
                }
                if let Some(motor) = self.motors.get_mut(index) {
                    motor.admit(piece);
                }
            }
            _ => {
                if let (Some(motor), Some(load)) =
                    (self.motors.get_mut(index), self.loads.get_mut(index))
                    && let Err(unfit) = motor.lay(&self.given.clock, piece, load)
                {
                    return Poll::Ready(Err(unfit.into()));
                }
            }
        }
        Poll::Pending
    }

    /// Called once the board has admitted all that is set up. All axes wait for `hold` before a
    /// turn, and until each has rested.
    fn wait_for_all(&mut self, mut hold: Ticks) {
        for motor in &self.motors {
            if motor.ordered() != Layout::Nothing {
                hold = hold.max(motor.rest());
            }
        }
        let mut bit = 1;
        for motor in &mut self.motors {
            if motor.ordered() != Layout::Nothing && motor.hold(hold) {
                self.starting |= bit;
                self.rested &= !bit;
            }
            bit <<= 1;
        }
    }

    /// Forgets the prepared orders; moving motors continue.
    #[inline(never)]
    pub fn cancel(&mut self) {
        let mut bit = 1;
        for motor in &mut self.motors {
            if motor.ordered() != Layout::Nothing {
                motor.forget();
                self.starting &= !bit;
            }
            bit <<= 1;
        }
    }
}

/// One function for all callers: `commit` is compiled for each that is given.
fn at_once() -> Ticks {
    0
}
