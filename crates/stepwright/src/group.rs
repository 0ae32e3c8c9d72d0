//! Plans the moves of N motors: orders in, runs out.

mod start;

use crate::board::Board;
use crate::clamp;
use crate::control::Control;
use crate::drive::Axes;
use crate::motor::{Horizon, Motor};
use crate::order::{Change, Refusal};
use crate::planner::{Clock, Layout, Load, Work};
use crate::queue::Producer;
use crate::units::{Speed, Ticks};

/// A board and the constants that planning derives from it, for a chip that has them in flash.
#[derive(Clone, Copy, Debug)]
pub struct PlannedBoard<const N: usize> {
    board: Board<N, ()>,
    clock: Clock,
    horizon: Horizon,
}

impl<const N: usize> PlannedBoard<N> {
    /// Derives the constants of a board.
    #[inline(always)]
    pub const fn new(board: Board<N>) -> PlannedBoard<N> {
        let clock = Clock::new(board.rate, &board.fit);
        PlannedBoard { clock, horizon: Horizon::new(board.horizon), board: board.kept() }
    }
}

/// The travels of N motors, each with `Q` queued entries, and which positions are known. Each call
/// borrows the engine.
pub(crate) struct Group<'q, const N: usize, const Q: usize> {
    feeds: [Producer<'q, Q>; N],
    motors: [Motor<Q>; N],
    /// What the travel of each axis requires of the board, as of its order or its last change.
    loads: [Load; N],
    given: PlannedBoard<N>,
    /// The run that is being planned, for the axis `turn`.
    work: Work,
    /// Axes whose travels start once the queues of all of them are filled.
    starting: Axes,
    uncertain: Axes,
    /// Axes that were at rest at the last call of `pass`.
    rested: Axes,
    /// The axis whose run is being planned.
    turn: u8,
}

impl<'q, const N: usize, const Q: usize> Group<'q, N, Q> {
    /// All motors at rest at position 0.
    #[inline(always)]
    pub const fn new(feeds: [Producer<'q, Q>; N], board: Board<N>) -> Self {
        Group {
            feeds,
            motors: [const { Motor::IDLE }; N],
            loads: [Load::NONE; N],
            given: PlannedBoard::new(board),
            work: Work::NONE,
            starting: 0,
            uncertain: 0,
            rested: 0,
            turn: 0,
        }
    }

    /// Initialises a group of zeros as [`new`](Group::new) does. `feed` writes the feed of an axis,
    /// `fill` the board.
    #[inline(always)]
    pub fn power_up(
        &mut self,
        mut feed: impl FnMut(u8, &mut Producer<'q, Q>),
        fill: impl FnOnce(&mut PlannedBoard<N>),
    ) {
        for (axis, own) in (0..).zip(&mut self.feeds) {
            feed(axis, own);
        }
        fill(&mut self.given);
        self.motors.iter_mut().for_each(Motor::power_up);
    }

    /// The board.
    pub fn board(&self) -> &Board<N, ()> {
        &self.given.board
    }

    /// The highest speed of an axis that moves alone: [`Board::max_speed`].
    pub fn max_speed(&self) -> Speed {
        self.given.board.max_alone(&self.given.clock)
    }

    /// The board, for changes: they apply to travels that begin from now on. Pass new drivers'
    /// times to the engine too, see [`Control::set_timing`].
    pub fn board_mut(&mut self) -> &mut Board<N, ()> {
        &mut self.given.board
    }

    /// Changes the travels of these axes, all or none: another target, or another limit from now
    /// on.
    ///
    /// The change takes effect after the steps that are already planned. These last for the board's
    /// [`horizon`](Board::horizon) and at most one run, or for the present step if that takes
    /// longer. A travel that has to turn brakes to rest and comes back by itself; its axis is busy
    /// all the while.
    ///
    /// A change of several axes is checked with their top speeds, whether they reach them or not:
    /// to compute the speed that each reaches takes as long as some runs, and nothing is planned
    /// meanwhile. What is left of each travel is set up by its next [`poll`](Group::poll).
    ///
    /// # Errors
    /// [`Refusal`]; then all axes continue unchanged.
    pub fn change(
        &mut self,
        engine: &mut impl Control,
        axes: Axes,
        change: Change,
    ) -> Result<(), Refusal> {
        let moving = self.moving(engine, 0);
        let resting = axes & !moving;
        if resting != 0 {
            return Err(if resting & !Self::ALL == 0 { Refusal::Resting } else { Refusal::NoAxis });
        }
        // Each axis is tried first, on one copy: a chip has no room for copies of all.
        let mut loads = self.loads;
        // (Any motor will do: a constant as the initial value would take RAM.)
        let Some(mut copy) = self.motors.first().copied() else { return Ok(()) };
        let PlannedBoard { board, clock, .. } = &self.given;
        let mut left = axes;
        for (motor, load) in self.motors.iter_mut().zip(&mut loads) {
            if left & 1 != 0 {
                motor.settle();
                copy.set(motor);
                copy.change(&change)?;
                copy.weigh(clock, load, !axes.is_power_of_two())?;
            }
            left >>= 1;
        }
        board.check_speed(clock, &loads, moving, axes)?;
        for axis in 0..N as u8 {
            if axes >> axis & 1 != 0 {
                board.check_ramps(&loads, moving, axis)?;
            }
        }
        self.loads = loads;
        self.work.drop();
        left = axes;
        for motor in &mut self.motors {
            if left & 1 != 0 {
                // It has been tried.
                _ = motor.change(&change);
            }
            left >>= 1;
        }
        Ok(())
    }

    /// All axes.
    const ALL: Axes = if N < 8 { (1 << N) - 1 } else { Axes::MAX };

    /// These axes and those that move.
    #[inline(never)]
    fn moving(&self, engine: &impl Control, mut moving: Axes) -> Axes {
        let mut bit = 1;
        for axis in 0..N as u8 {
            if moving & bit == 0 && self.is_busy(engine, axis) {
                moving |= bit;
            }
            bit <<= 1;
        }
        moving
    }

    /// Queues the beginning of the travel that is set up for an axis.
    fn begin(&mut self, axis: u8) {
        let lead = clamp::sum(self.given.board.timing.setup, self.given.board.lead);
        let index = usize::from(axis);
        if let (Some(motor), Some(feed)) = (self.motors.get_mut(index), self.feeds.get_mut(index)) {
            motor.begin(feed, lead, &self.given.horizon);
        }
    }

    /// Reports that this many ticks have passed since the last call. Two travels of an axis are one
    /// interval of the start speed apart, or from rest the first interval of a ramp, √(2/a), and at
    /// least one interval of the top speed. The time since the last pulse counts as part of that.
    /// Without these calls the next travel waits for all of it. Call it every few milliseconds.
    pub fn pass(&mut self, engine: &impl Control, ticks: Ticks) {
        let mut bit = 1;
        for (axis, motor) in self.motors.iter_mut().enumerate() {
            // The time before the axis was first seen at rest does not count: the last pulse may
            // have come within it.
            let rests = self.starting & bit == 0 && engine.is_idle(axis as u8);
            if rests && self.rested & bit != 0 {
                motor.pass(ticks);
            }
            self.rested = if rests { self.rested | bit } else { self.rested & !bit };
            bit <<= 1;
        }
    }

    /// Does one piece of planning: a part of one run, for the axis whose queue runs out first. Call
    /// it again at once while it returns true, and at least every millisecond.
    pub fn poll(&mut self, engine: &mut impl Control) -> bool {
        if !self.work.is_begun() {
            let (mut least, mut turns, mut begins, mut axis) = (u8::MAX, false, false, 0);
            for (motor, feed) in self.motors.iter_mut().zip(&mut self.feeds) {
                let ahead = motor.wants(feed, &self.given.horizon, || engine.playing(axis));
                if ahead < least {
                    (least, self.turn) = (ahead, axis);
                }
                turns |= motor.is_to_turn();
                begins |= motor.ordered() == Layout::Begin;
                axis += 1;
            }
            if turns && self.turn_round(engine) {
                return true;
            }
            if least == u8::MAX {
                // The axes of an order start together.
                if begins {
                    return false;
                }
                let starting = core::mem::take(&mut self.starting);
                if starting != 0 {
                    engine.start(starting);
                }
                return starting != 0;
            }
        }
        let index = usize::from(self.turn);
        if let (Some(motor), Some(feed)) = (self.motors.get_mut(index), self.feeds.get_mut(index)) {
            motor.plan(feed, &self.given.clock, &mut self.work, &self.given.horizon);
        }
        true
    }

    /// Begins the next leg of an axis that had to come to rest for it. Returns false if there is
    /// none.
    #[inline(never)]
    fn turn_round(&mut self, engine: &impl Control) -> bool {
        let mut bit = 1;
        for (axis, motor) in (0u8..).zip(&mut self.motors) {
            if motor.is_to_turn() && self.starting & bit == 0 && engine.is_idle(axis) {
                motor.turn();
                motor.hold(self.given.board.timing.hold.max(motor.rest()));
                self.starting |= bit;
                self.rested &= !bit;
                self.begin(axis);
                return true;
            }
            bit <<= 1;
        }
        false
    }

    /// Stops an axis along its ramp; the position stays known. Takes effect after the queued steps:
    /// see [`Board::horizon`].
    pub fn stop(&mut self, axis: u8) {
        if let Some(motor) = self.motors.get_mut(usize::from(axis)) {
            motor.brake();
            // The run that is being planned starts again, even if it belongs to another axis, which
            // costs a little time and nothing else. A run that has already been taken is still
            // queued: the axis brakes from its end.
            self.work.drop();
        }
    }

    /// Stops these axes between two steps. A motor that moved may have lost steps: its position is
    /// unknown from now on.
    pub fn kill(&mut self, engine: &mut impl Control, axes: Axes) {
        for axis in 0..N as u8 {
            if axes >> axis & 1 != 0 && !engine.is_idle(axis) {
                self.uncertain |= 1 << axis;
            }
        }
        self.kill_at_switch(engine, axes);
    }

    /// Stops these axes between two steps. The position is that of the last step and stays known:
    /// use this only for a motor that stops without slipping.
    pub fn kill_at_switch(&mut self, engine: &mut impl Control, axes: Axes) {
        // An axis at rest stays at rest, even if a travel was set up for it and refused.
        let moving = axes & self.moving(engine, 0);
        engine.kill(axes);
        self.starting &= !axes;
        // A run of a killed axis is never queued; a run of another axis may already count in its
        // travel.
        if axes >> self.turn & 1 != 0 {
            self.work.clear();
        }
        let motors = self.motors.iter_mut().zip(&mut self.feeds);
        for (axis, (motor, feed)) in motors.enumerate() {
            if moving >> axis & 1 != 0 {
                motor.abandon(feed, &self.given.clock, engine.is_forward(axis as u8));
            }
        }
    }

    /// The end of the planned part of a travel, in steps from where the travel began: a change
    /// takes effect there. `None` if that is more than 2³¹ steps away, or if there is no such axis.
    pub fn planned(&self, axis: u8) -> Option<i32> {
        self.motors.get(usize::from(axis)).and_then(Motor::planned)
    }

    /// Whether a target, in steps from where the travel of an axis began, lies forward of the
    /// [`planned`](Group::planned) part of the travel; false if there is no such axis.
    pub fn is_ahead(&self, axis: u8, target: i32) -> bool {
        self.motors.get(usize::from(axis)).is_some_and(|motor| motor.is_ahead(target))
    }

    /// Whether the last or present travel of an axis goes forward, at the end of its planned part;
    /// false if there is no such axis.
    pub fn is_forward(&self, axis: u8) -> bool {
        self.motors.get(usize::from(axis)).is_some_and(Motor::is_forward)
    }

    /// Whether a travel of this axis is in progress; false if there is no such axis.
    #[inline(never)]
    pub fn is_busy(&self, engine: &impl Control, axis: u8) -> bool {
        match self.motors.get(usize::from(axis)) {
            Some(motor) => {
                // A prepared order has no direction yet; its axis is at rest until the order
                // begins.
                let begins = self.starting >> axis & 1 != 0 && motor.ordered() == Layout::Nothing;
                motor.planning() || begins || !engine.is_idle(axis)
            }
            None => false,
        }
    }

    /// Whether any axis is busy.
    pub fn any_busy(&self, engine: &impl Control) -> bool {
        (0..N as u8).any(|axis| self.is_busy(engine, axis))
    }

    /// Whether any axis has a travel without an end.
    pub fn any_endless(&self) -> bool {
        self.motors.iter().any(Motor::is_endless)
    }

    /// The position of an axis in steps, also during a move; `None` if it is unknown, or if there
    /// is no such axis.
    pub fn position(&self, engine: &impl Control, axis: u8) -> Option<i64> {
        let known = usize::from(axis) < N && self.uncertain >> axis & 1 == 0;
        known.then(|| engine.position(axis))
    }

    /// Sets the present position to 0; it is known again.
    pub fn zero(&mut self, engine: &mut impl Control, axis: u8) {
        if usize::from(axis) < N {
            engine.set_position(axis, 0);
            self.uncertain &= !(1 << axis);
        }
    }

    /// Sets the present position of an axis at rest; it is known again.
    pub fn set_position(&mut self, engine: &mut impl Control, axis: u8, position: i64) {
        if usize::from(axis) < N {
            engine.set_position(axis, position);
            self.uncertain &= !(1 << axis);
        }
    }

    /// The target of the travel of an axis, in steps from where the travel began, also after a
    /// stop. `None` for a travel without an end, for one that ends more than 2³¹ steps away, and if
    /// there is no such axis.
    pub fn target(&self, axis: u8) -> Option<i32> {
        self.motors.get(usize::from(axis)).and_then(Motor::target)
    }

    /// Whether the travel of an axis has no end; false if there is no such axis.
    pub fn is_endless(&self, axis: u8) -> bool {
        self.motors.get(usize::from(axis)).is_some_and(Motor::is_endless)
    }

    /// How long planning may wait, in ticks: half of the time that is queued, for the axis whose
    /// queue runs out first or that is to turn. A present run whose remaining time is not known
    /// does not count. `None` if there is nothing to plan.
    pub fn may_wait(&mut self, engine: &mut impl Control) -> Option<Ticks> {
        let mut least = None;
        for (axis, (motor, feed)) in (0u8..).zip(self.motors.iter_mut().zip(&self.feeds)) {
            let wait = motor.may_wait(feed, &self.given.horizon, || engine.playing(axis));
            least = least.into_iter().chain(wait).min();
        }
        least
    }

    /// Marks all positions as unknown.
    pub fn mark_positions_unknown(&mut self) {
        self.uncertain = Axes::MAX;
    }

    /// Marks the positions of these axes as unknown.
    pub fn mark_unknown(&mut self, axes: Axes) {
        self.uncertain |= axes;
    }

    /// The axes whose position is unknown.
    pub fn uncertain(&self) -> Axes {
        self.uncertain
    }
}
