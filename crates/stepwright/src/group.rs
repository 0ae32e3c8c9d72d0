//! Plans the moves of N motors: orders go in, runs come out.

mod start;

use crate::board::Board;
use crate::clamp;
use crate::control::Control;
use crate::drive::Axes;
use crate::motor::{Horizon, Motor, Pass};
use crate::order::{Change, Refusal};
use crate::planner::{Clock, Layout, Load, Work};
use crate::queue::Producer;
use crate::units::{Speed, Ticks};

/// A board with the constants that planning derives from it, for a chip that has them in flash.
#[derive(Clone, Copy, Debug)]
pub struct PlannedBoard<const N: usize> {
    board: Board<N, ()>,
    clock: Clock,
    horizon: Horizon,
}

impl<const N: usize> PlannedBoard<N> {
    /// Of a board.
    #[inline(always)]
    pub const fn new(board: Board<N>) -> PlannedBoard<N> {
        let clock = Clock::new(board.rate, &board.fit);
        PlannedBoard { clock, horizon: Horizon::new(board.horizon), board: board.kept() }
    }
}

/// The travels of N motors, each with `Q` queued entries; positions are known, or known to be
/// unknown. Each call is lent the engine.
pub(crate) struct Group<'q, const N: usize, const Q: usize> {
    feeds: [Producer<'q, Q>; N],
    motors: [Motor<Q>; N],
    /// What the travel of each axis asks of the board, since it was ordered or changed.
    loads: [Load; N],
    given: PlannedBoard<N>,
    /// The run that is being planned, of the axis whose turn it is.
    work: Work,
    /// Axes whose travel waits until all of them have their queues filled.
    starting: Axes,
    uncertain: Axes,
    /// Axes that rested when time passed last.
    rested: Axes,
    /// The axis whose run is planned.
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

    /// Makes a group of zeros what [`new`](Group::new) makes. `feed` writes the feed of an axis,
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

    /// The board, to be changed: holds for travels that begin from now on. New
    /// drivers' times belong into the engine too, see [`Control::set_timing`].
    pub fn board_mut(&mut self) -> &mut Board<N, ()> {
        &mut self.given.board
    }

    /// Changes the travels that these axes are on, all or none: another target,
    /// or another limit from here on.
    ///
    /// Takes hold after what is planned already, which lasts for the board's
    /// [`horizon`](Board::horizon) and one run at most, or for the present step where that takes
    /// longer. A travel that has to turn brakes to rest and goes back by itself; its axis is busy
    /// all the while.
    ///
    /// A change of several axes is judged by their top speeds, whether they reach them or not: to look
    /// for what each reaches takes as long as some runs, and nothing is planned meanwhile. (Of the way back
    /// to a target behind this is said of axes with a limit of jerk alone.)
    ///
    /// # Errors
    /// [`Refusal`], and all goes on as it was.
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
        // Each is tried first, alone: a chip has no room for copies of them all.
        let mut loads = self.loads;
        // (Any: a constant to begin with would have a place in RAM.)
        let Some(mut copy) = self.motors.first().copied() else { return Ok(()) };
        let alone = axes.is_power_of_two();
        let (mut pass, mut done) = (if alone { Pass::Exact } else { Pass::Quick }, false);
        loop {
            let mut left = axes;
            for (motor, load) in self.motors.iter_mut().zip(&mut loads) {
                if left & 1 != 0 {
                    let motor = if pass != Pass::Real {
                        copy.set(motor);
                        &mut copy
                    } else if done {
                        motor.set(&copy);
                        break;
                    } else {
                        motor
                    };
                    let whole = motor.change(&self.given.clock, &change, load, pass)?;
                    // Of one axis the copy is what it is to be.
                    done = whole && pass == Pass::Exact;
                }
                left >>= 1;
            }
            if pass == Pass::Real {
                self.work.drop();
                return Ok(());
            }
            for axis in 0..N as u8 {
                if axes >> axis & 1 != 0 {
                    let PlannedBoard { board, clock, .. } = &self.given;
                    board.check_speed(clock, &loads, moving, axis)?;
                    board.check_ramps(&loads, moving, axis)?;
                }
            }
            self.loads = loads;
            pass = Pass::Real;
        }
    }

    /// All axes.
    const ALL: Axes = if N < 8 { (1 << N) - 1 } else { Axes::MAX };

    /// These axes, and those that move.
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

    /// Queues the beginning of what an axis has set up.
    fn begin(&mut self, axis: u8) {
        let lead = clamp::sum(self.given.board.timing.setup, self.given.board.lead);
        let index = usize::from(axis);
        if let (Some(motor), Some(feed)) = (self.motors.get_mut(index), self.feeds.get_mut(index)) {
            motor.begin(feed, lead, &self.given.horizon);
        }
    }

    /// This many ticks have passed since the last call. Two travels of an axis lie an interval
    /// of the start speed apart, or from rest the first interval of a ramp, √(2/a), and no
    /// less than one of the top speed; what has passed of that since the last pulse the next
    /// travel need not wait for. Without these calls it waits for all of it. To be called
    /// every few milliseconds.
    pub fn pass(&mut self, engine: &impl Control, ticks: Ticks) {
        let mut bit = 1;
        for (axis, motor) in self.motors.iter_mut().enumerate() {
            // What passed before it was seen at rest does not count: the last pulse may
            // have come in between.
            let rests = self.starting & bit == 0 && engine.is_idle(axis as u8);
            if rests && self.rested & bit != 0 {
                motor.pass(ticks);
            }
            self.rested = if rests { self.rested | bit } else { self.rested & !bit };
            bit <<= 1;
        }
    }

    /// Does one piece of planning: a part of one run of the axis whose queue lasts the
    /// shortest. Call it again at once while it answers true, and at least every millisecond.
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

    /// Begins the next leg of an axis that rests before it. False if there is none.
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

    /// Stops an axis along its ramp; the position stays known.
    /// Takes effect after what is queued: see [`Board::horizon`].
    pub fn stop(&mut self, axis: u8) {
        if let Some(motor) = self.motors.get_mut(usize::from(axis)) {
            motor.brake();
            // If it is this axis that is planned, its run starts again; if not, another's
            // does, which costs a little time and nothing else. A run that has been taken is
            // queued yet: the axis brakes from its end.
            self.work.drop();
        }
    }

    /// Stops these axes between two steps. A motor that moved may have lost steps: its
    /// position is uncertain from now on.
    pub fn kill(&mut self, engine: &mut impl Control, axes: Axes) {
        for axis in 0..N as u8 {
            if axes >> axis & 1 != 0 && !engine.is_idle(axis) {
                self.uncertain |= 1 << axis;
            }
        }
        self.kill_at_switch(engine, axes);
    }

    /// Stops these axes between two steps. The position is where the last step
    /// led to, and stays known: only for a motor that stops where it is told.
    pub fn kill_at_switch(&mut self, engine: &mut impl Control, axes: Axes) {
        // What rests already goes on resting, whatever was set up for it and refused.
        let moving = axes & self.moving(engine, 0);
        engine.kill(axes);
        self.starting &= !axes;
        // Its run is never queued; another axis' may have been taken from its travel.
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

    /// Where the part of a travel that is planned leads to, in steps from where
    /// the travel began: a change takes hold there. `None` if that is more than
    /// 2³¹ steps away, or there is no such axis.
    pub fn planned(&self, axis: u8) -> Option<i32> {
        self.motors.get(usize::from(axis)).and_then(Motor::planned)
    }

    /// Whether a target this many steps from where the travel of an axis began lies
    /// forward of where that is [`planned`](Group::planned) to; false if there is
    /// no such axis.
    pub fn is_ahead(&self, axis: u8, target: i32) -> bool {
        self.motors.get(usize::from(axis)).is_some_and(|motor| motor.is_ahead(target))
    }

    /// Whether the last or present travel of an axis leads forward, as far as
    /// it is planned; false if there is no such axis.
    pub fn is_forward(&self, axis: u8) -> bool {
        self.motors.get(usize::from(axis)).is_some_and(Motor::is_forward)
    }

    /// Whether a travel of this axis is in progress; false if there is no
    /// such axis.
    #[inline(never)]
    pub fn is_busy(&self, engine: &impl Control, axis: u8) -> bool {
        match self.motors.get(usize::from(axis)) {
            Some(motor) => {
                // What is ordered has no direction yet, and rests until it begins.
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

    /// Whether any axis goes on until it is stopped.
    pub fn any_endless(&self) -> bool {
        self.motors.iter().any(Motor::is_endless)
    }

    /// The position of an axis in steps, also on the way; `None` when it is
    /// uncertain, or there is no such axis.
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

    /// Calls the present position this many steps; it is certain again. For an axis at rest.
    pub fn set_position(&mut self, engine: &mut impl Control, axis: u8, position: i64) {
        if usize::from(axis) < N {
            engine.set_position(axis, position);
            self.uncertain &= !(1 << axis);
        }
    }

    /// Where the travel of an axis is to end, in steps from where it began, also after a
    /// stop. `None` for one that goes on until it is stopped, one that ends more than 2³¹
    /// steps away, and an axis that there is not.
    pub fn target(&self, axis: u8) -> Option<i32> {
        self.motors.get(usize::from(axis)).and_then(Motor::target)
    }

    /// Whether an axis goes on until it is stopped; false if there is no such axis.
    pub fn is_endless(&self, axis: u8) -> bool {
        self.motors.get(usize::from(axis)).is_some_and(Motor::is_endless)
    }

    /// How long planning may wait, in ticks: half of what is queued, but for a present run of
    /// which nobody knows how much is left, of the axis whose queue lasts the shortest, or of
    /// one that is to turn. `None` if there is nothing to plan.
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

    /// Axes whose position is uncertain.
    pub fn uncertain(&self) -> Axes {
        self.uncertain
    }
}
