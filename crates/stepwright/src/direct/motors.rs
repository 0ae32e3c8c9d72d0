//! N motors whose law runs in the interrupt: what a user holds.
//!
//! The direct counterpart of a [`Group`](crate::Group): there is nothing to
//! plan, so there is nothing to be called in time but
//! [`poll`](Motors::poll), once a day.

use super::feed::Direct;
use super::ramp::Ramp;
use crate::board::Board;
use crate::drive::{Axes, Drive};
use crate::engine::Engine;
use crate::group::Control;
use crate::order::{Order, Refusal, Travel};
use crate::timer::StepTimer;
use crate::units::Ticks;

/// What the foreground asks of an engine whose feeds are [`Direct`].
///
/// On a chip each call holds the step interrupt off.
pub trait Steering: Control {
    /// Has an axis at rest travel when it is started.
    fn begin(&mut self, axis: u8, forward: bool, hold: Ticks, lead: Ticks, ramp: Ramp);
    /// See [`Direct::brake`].
    fn brake(&mut self, axis: u8);
    /// See [`Ramp::go_on`].
    fn go_on(&mut self, axis: u8);
}

impl<T: StepTimer, D: Drive, const N: usize> Steering for Engine<T, D, Direct, N> {
    fn begin(&mut self, axis: u8, forward: bool, hold: Ticks, lead: Ticks, ramp: Ramp) {
        if let Some(feed) = self.feed(axis) {
            feed.begin(forward, hold, lead, ramp);
        }
    }
    fn brake(&mut self, axis: u8) {
        if let Some(feed) = self.feed(axis) {
            feed.brake();
        }
    }
    fn go_on(&mut self, axis: u8) {
        if let Some(feed) = self.feed(axis) {
            feed.ramp.go_on();
        }
    }
}

/// N motors along Austin's ramp.
pub struct Motors<const N: usize> {
    board: Board<N>,
    /// Highest speed of each axis's travel, in 0.001 steps/s.
    peaks: [u32; N],
    /// Laid out, and not yet started.
    prepared: Axes,
    endless: Axes,
    uncertain: Axes,
}

impl<const N: usize> Motors<N> {
    /// All motors at rest at position 0.
    pub const fn new(board: Board<N>) -> Motors<N> {
        Motors { board, peaks: [0; N], prepared: 0, endless: 0, uncertain: 0 }
    }

    /// The board.
    pub fn board(&self) -> &Board<N> {
        &self.board
    }

    /// Lays out one travel of an order; [`commit`](Motors::commit) starts all
    /// that were.
    ///
    /// # Errors
    /// [`Refusal`]; then [`cancel`](Motors::cancel) what was laid out before.
    pub fn prepare(
        &mut self,
        engine: &mut impl Steering,
        axis: u8,
        order: &Order,
    ) -> Result<(), Refusal> {
        if self.is_busy(engine, axis) {
            return Err(Refusal::Busy);
        }
        let Some(peak) = self.peaks.get_mut(usize::from(axis)) else {
            return Err(Refusal::NoAxis);
        };
        let ramp = Ramp::of(self.board.rate, order)?;
        if order.travel == Travel::By(0) {
            return Ok(());
        }
        // Whether a short travel reaches it is not asked.
        *peak = order.top.millisteps();
        let bit = 1u8 << (axis & 7);
        let endless = matches!(order.travel, Travel::Endless(_));
        self.endless = if endless { self.endless | bit } else { self.endless & !bit };
        self.prepared |= bit;
        let timing = self.board.timing;
        let lead = timing.setup.saturating_add(self.board.lead);
        engine.begin(axis, order.travel.forward(), timing.hold, lead, ramp);
        Ok(())
    }

    /// Starts what was laid out.
    ///
    /// # Errors
    /// [`Refusal::TooFast`], and nothing moves; then
    /// [`cancel`](Motors::cancel) it.
    pub fn commit(&mut self, engine: &mut impl Steering) -> Result<(), Refusal> {
        let mut moving = self.prepared;
        for axis in 0..N as u8 {
            if !engine.is_idle(axis) {
                moving |= 1 << axis;
            }
        }
        self.board.check(&self.peaks, moving, self.prepared)?;
        engine.start(core::mem::take(&mut self.prepared));
        Ok(())
    }

    /// Forgets what was laid out; a motor that moves goes on.
    pub fn cancel(&mut self, engine: &mut impl Steering) {
        engine.halt(core::mem::take(&mut self.prepared));
    }

    /// Has endless travels go on. To be called at least once a day.
    pub fn poll(&mut self, engine: &mut impl Steering) {
        for axis in 0..N as u8 {
            if self.endless >> axis & 1 != 0 {
                engine.go_on(axis);
            }
        }
    }

    /// Brakes an axis along its ramp, two steps from now.
    pub fn brake(&mut self, engine: &mut impl Steering, axis: u8) {
        engine.brake(axis);
    }

    /// Stops all axes between two steps. A motor that moved may have lost
    /// steps: its position is uncertain from now on.
    pub fn kill(&mut self, engine: &mut impl Steering) {
        for axis in 0..N as u8 {
            if !engine.is_idle(axis) {
                self.uncertain |= 1 << axis;
            }
        }
        self.prepared = 0;
        engine.halt(Axes::MAX);
    }

    /// Whether a travel of this axis is in progress; false if there is none.
    pub fn is_busy(&self, engine: &impl Control, axis: u8) -> bool {
        usize::from(axis) < N && (self.prepared >> axis & 1 != 0 || !engine.is_idle(axis))
    }

    /// The position of an axis in steps; `None` when it is uncertain, or there
    /// is no such axis.
    pub fn position(&self, engine: &impl Control, axis: u8) -> Option<i64> {
        let known = usize::from(axis) < N && self.uncertain >> axis & 1 == 0;
        known.then(|| engine.position(axis))
    }

    /// Calls the present position 0; it is certain again.
    pub fn zero(&mut self, engine: &mut impl Control, axis: u8) {
        if usize::from(axis) < N {
            engine.set_position(axis, 0);
            self.uncertain &= !(1 << axis);
        }
    }

    /// Calls all positions uncertain.
    pub fn doubt(&mut self) {
        self.uncertain = Axes::MAX;
    }

    /// Axes whose position is uncertain.
    pub fn uncertain(&self) -> Axes {
        self.uncertain
    }
}
