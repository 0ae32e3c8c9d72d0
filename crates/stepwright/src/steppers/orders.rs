//! Motors whose orders have their own limits: a controller's, behind a serial line.

use core::task::Poll;

use super::{Axis, AxisSet, Steppers};
use crate::board::Board;
use crate::drive::Axes;
use crate::group::{Control, Given, Group};
use crate::order::{Change, Order, Refusal};
use crate::queue::Producer;
use crate::units::{Speed, Ticks};

impl<'q, E: Control, const N: usize, const Q: usize> Steppers<'q, E, N, Q, ()> {
    /// All motors at rest at position 0.
    ///
    /// `feeds` MUST be those of the engine's queues, in the order of its axes.
    pub const fn for_orders(engine: E, feeds: [Producer<'q, Q>; N], board: Board<N>) -> Self {
        Steppers { group: Group::new(feeds, board), engine, axes: [(); N] }
    }

    /// Makes [blank](Steppers::blank) ones what [`for_orders`](Steppers::for_orders) makes.
    /// `feed` writes the feed of an axis, and `fill` what is given.
    #[inline(always)]
    pub fn power_up_for_orders(
        &mut self,
        feed: impl FnMut(u8, &mut Producer<'q, Q>),
        fill: impl FnOnce(&mut Given<N>),
    ) {
        self.group.power_up(feed, fill);
    }

    /// Starts the ordered axes together, all or none.
    ///
    /// # Errors
    /// [`Refusal`], and nothing moves.
    pub fn start(
        &mut self,
        orders: impl IntoIterator<Item = (Axis<N>, Order)>,
    ) -> Result<(), Refusal> {
        let orders = orders.into_iter().map(|(axis, order)| (axis.number(), order));
        self.group.start(&mut self.engine, orders)
    }

    /// Takes one travel of an order. [`commit`](Steppers::commit) starts all that were
    /// taken, together.
    ///
    /// # Errors
    /// [`Refusal`]; then [`cancel`](Steppers::cancel) what was prepared before.
    #[inline(always)]
    pub fn prepare(&mut self, axis: Axis<N>, order: &Order) -> Result<(), Refusal> {
        self.group.prepare(&mut self.engine, axis.number(), order)
    }

    /// Does one piece of starting what was prepared, to be called until it is ready. It
    /// starts `wait` ticks later than it could.
    ///
    /// # Errors
    /// [`Refusal`], and nothing moves; then [`cancel`](Steppers::cancel) it.
    #[inline(always)]
    pub fn commit(&mut self, wait: impl FnOnce() -> Ticks) -> Poll<Result<(), Refusal>> {
        self.group.commit(&mut self.engine, wait)
    }

    /// The highest speed of an axis that moves alone: [`Board::max_speed`].
    pub fn max_speed(&self) -> Speed {
        self.group.max_speed()
    }

    /// Forgets what was prepared; a motor that moves goes on.
    #[inline(always)]
    pub fn cancel(&mut self) {
        self.group.cancel();
    }

    /// Changes the travels that these axes are on, all or none: see [`Change`].
    ///
    /// # Errors
    /// [`Refusal`], and all goes on as it was.
    #[inline(always)]
    pub fn change(&mut self, axes: impl Into<AxisSet<N>>, change: Change) -> Result<(), Refusal> {
        self.group.change(&mut self.engine, axes.into().bits(), change)
    }

    /// Brakes one axis along its ramp: [`stop`](Steppers::stop) for a set of one.
    #[inline(always)]
    pub fn brake(&mut self, axis: Axis<N>) {
        self.group.brake(axis.number());
    }

    /// Whether a target this many steps from where the travel of an axis began lies forward
    /// of where that is planned to.
    #[inline(always)]
    pub fn leads_forward(&self, axis: Axis<N>, target: i32) -> bool {
        self.group.leads_forward(axis.number(), target)
    }

    /// Where the part of a travel that is planned leads to, in steps from where it began: a
    /// change takes hold there. `None` if that is more than 2³¹ steps away.
    pub fn planned(&self, axis: Axis<N>) -> Option<i32> {
        self.group.planned(axis.number())
    }

    /// Whether the last or present travel of an axis leads forward, as far as it is planned.
    #[inline(always)]
    pub fn is_forward(&self, axis: Axis<N>) -> bool {
        self.group.is_forward(axis.number())
    }

    /// Whether any axis goes on until it is stopped.
    #[inline(always)]
    pub fn any_endless(&self) -> bool {
        self.group.any_endless()
    }

    /// Stops all axes between two steps. The position of a motor that moved is not known
    /// from now on.
    #[inline(always)]
    pub fn kill(&mut self) {
        self.group.kill(&mut self.engine);
    }

    /// Stops these axes between two steps, at a switch: their positions stay known, as far
    /// as the steps tell.
    #[inline(always)]
    pub fn halt_at_switch(&mut self, axes: impl Into<AxisSet<N>>) {
        self.group.halt(&mut self.engine, axes.into().bits());
    }

    /// Calls all positions unknown: something else may have moved the motors.
    #[inline(always)]
    pub fn doubt(&mut self) {
        self.group.doubt();
    }

    /// Axes whose position is not known; bits beyond N may be set.
    #[inline(always)]
    pub fn uncertain(&self) -> Axes {
        self.group.uncertain()
    }

    /// Calls the present position of an axis at rest 0.
    #[inline(always)]
    pub fn zero(&mut self, axis: Axis<N>) {
        self.group.zero(&mut self.engine, axis.number());
    }
}
