//! Motors whose orders have their own limits, as those of a controller behind a serial line.

use core::mem::MaybeUninit;
use core::task::Poll;

use crate::board::Board;
use crate::control::Control;
use crate::drive::Axes;
use crate::group::{Group, PlannedBoard};
use crate::order::{Change, Order, Refusal};
use crate::queue::Producer;
use crate::steppers::{Axis, AxisSet};
use crate::units::{Speed, Ticks};

/// N motors that take [orders](Order), each with its own limits, as a controller does that gets its
/// orders over a serial line. A program that sets the limits of an axis once uses
/// [`Steppers`](crate::Steppers).
///
/// Made of an engine or a handle to one in an interrupt (`E`, a [`Control`]), the feeds of the
/// engine's queues (`Q` runs each) and the board.
///
/// An order may be started in one call, [`start`](OrderedMotors::start), or in pieces of 200 µs on
/// a 16 MHz AVR (more with a jerk limit): [`prepare`](OrderedMotors::prepare), [`commit`](OrderedMotors::commit). The main
/// loop calls [`plan`](OrderedMotors::plan).
pub struct OrderedMotors<'q, E, const N: usize, const Q: usize = 8> {
    pub(crate) group: Group<'q, N, Q>,
    pub(crate) engine: E,
}

impl<'q, E: Control, const N: usize, const Q: usize> OrderedMotors<'q, E, N, Q> {
    /// All motors at rest at position 0.
    ///
    /// `feeds` MUST be the feeds of the engine's queues, in the order of its axes.
    pub const fn new(engine: E, feeds: [Producer<'q, Q>; N], board: Board<N>) -> Self {
        OrderedMotors { group: Group::new(feeds, board), engine }
    }

    /// Motors before power-up, for a static on a chip: all zeros except the engine, so they take no
    /// flash and are not moved over the stack.
    ///
    /// # Safety
    /// Before [`power_up`](OrderedMotors::power_up) or [`fill`](OrderedMotors::fill) no method may
    /// be called except [`engine`](OrderedMotors::engine).
    pub const unsafe fn blank(engine: E) -> Self {
        // SAFETY: zeros are valid numbers, and the enums begin at 0. A queue that is not set yet is
        // a raw pointer, which the caller promises not to use.
        OrderedMotors { group: unsafe { MaybeUninit::zeroed().assume_init() }, engine }
    }

    /// Initialises [blank](OrderedMotors::blank) motors as [`new`](OrderedMotors::new) does. `feed`
    /// writes the feed of an axis, `fill` the board.
    #[inline(always)]
    pub fn power_up(
        &mut self,
        feed: impl FnMut(u8, &mut Producer<'q, Q>),
        fill: impl FnOnce(&mut PlannedBoard<N>),
    ) {
        self.group.power_up(feed, fill);
    }

    /// Initialises [blank](OrderedMotors::blank) motors as [`new`](OrderedMotors::new) does, in
    /// place: they are never on the stack.
    #[inline]
    pub fn fill(&mut self, engine: E, feeds: [Producer<'q, Q>; N], board: &Board<N>) {
        self.engine = engine;
        let mut feeds = feeds.into_iter();
        let feed = |_, place: &mut Producer<'q, Q>| {
            if let Some(feed) = feeds.next() {
                *place = feed;
            }
        };
        self.power_up(feed, |given| *given = PlannedBoard::new(*board));
    }

    /// Starts the axes of these orders together, all or none.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, order), (Axis::Z, order)])?;
    /// assert!(motors.is_moving(Axis::Z) && !motors.is_moving(Axis::Y));
    /// # Ok::<(), Refusal>(())
    /// ```
    ///
    /// # Errors
    /// [`Refusal`]; then nothing moves.
    pub fn start(
        &mut self,
        orders: impl IntoIterator<Item = (Axis<N>, Order)>,
    ) -> Result<(), Refusal> {
        let orders = orders.into_iter().map(|(axis, order)| (axis.number(), order));
        self.group.start(&mut self.engine, orders)
    }

    /// Takes an order for one axis. [`commit`](OrderedMotors::commit) starts all prepared axes
    /// together.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.prepare(Axis::X, &order)?;
    /// motors.prepare(Axis::Y, &order)?;
    /// while motors.commit(|| 0)?.is_pending() {}
    /// assert!(motors.is_moving(Axis::X) && motors.is_moving(Axis::Y));
    /// # Ok::<(), Refusal>(())
    /// ```
    ///
    /// # Errors
    /// [`Refusal`]; then [`cancel`](OrderedMotors::cancel) the axes that were prepared before.
    #[inline(always)]
    pub fn prepare(&mut self, axis: Axis<N>, order: &Order) -> Result<(), Refusal> {
        self.group.prepare(&mut self.engine, axis.number(), order)
    }

    /// Does one piece of starting the prepared orders; call it until it is ready. The axes start
    /// `wait` ticks later than they could.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.prepare(Axis::X, &order)?;
    /// // A thousand ticks later than it could; other work may come between the pieces.
    /// while motors.commit(|| 1_000)?.is_pending() {}
    /// # Ok::<(), Refusal>(())
    /// ```
    ///
    /// # Errors
    /// [`Refusal`]; then nothing moves, and [`cancel`](OrderedMotors::cancel) must be called.
    #[inline(always)]
    pub fn commit(&mut self, wait: impl FnOnce() -> Ticks) -> Poll<Result<(), Refusal>> {
        self.group.commit(&mut self.engine, wait)
    }

    /// The highest speed of an axis that moves alone: [`Board::max_speed`].
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// let top = motors.max_speed();
    /// let order = stepwright::Order { top, ..order };
    /// motors.start([(Axis::X, order)])?;
    /// # Ok::<(), Refusal>(())
    /// ```
    pub fn max_speed(&self) -> Speed {
        self.group.max_speed()
    }

    /// Forgets the prepared orders; moving motors continue.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.prepare(Axis::X, &order)?;
    /// motors.cancel();
    /// assert!(!motors.any_moving());
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn cancel(&mut self) {
        self.group.cancel();
    }

    /// Changes the travels of these axes, all or none: see [`Change`].
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, order)])?;
    /// motors.change(Axis::X, Change::Target(-500))?;
    /// assert_eq!(motors.change(Axis::Y, Change::Target(-500)), Err(Refusal::Resting));
    /// # Ok::<(), Refusal>(())
    /// ```
    ///
    /// # Errors
    /// [`Refusal`]; then all axes continue unchanged.
    #[inline(always)]
    pub fn change(&mut self, axes: impl Into<AxisSet<N>>, change: Change) -> Result<(), Refusal> {
        self.group.change(&mut self.engine, axes.into().bits(), change)
    }

    /// Stops an axis along its ramp; its position stays known. The ramp begins after the steps that
    /// are already planned: see [`Board::horizon`].
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, order)])?;
    /// motors.stop(Axis::X);
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn stop(&mut self, axis: Axis<N>) {
        self.group.stop(axis.number());
    }

    /// Whether a target, in steps from where the travel of an axis began, lies forward of the end
    /// of the planned part of the travel.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, order)])?;
    /// assert!(motors.is_ahead(Axis::X, 3_000));
    /// assert!(!motors.is_ahead(Axis::X, -1));
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn is_ahead(&self, axis: Axis<N>, target: i32) -> bool {
        self.group.is_ahead(axis.number(), target)
    }

    /// The end of the planned part of a travel, in steps from where the travel began: a change
    /// takes effect there. `None` if that is more than 2³¹ steps away.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, order)])?;
    /// while motors.plan() {}
    /// assert!(motors.planned(Axis::X).is_some_and(|steps| (1..2_000).contains(&steps)));
    /// # Ok::<(), Refusal>(())
    /// ```
    pub fn planned(&self, axis: Axis<N>) -> Option<i32> {
        self.group.planned(axis.number())
    }

    /// Whether the last or present travel of an axis goes forward, at the end of its planned part.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, AxisLimits::DEFAULT.order(Travel::By(-3)))])?;
    /// assert!(!motors.is_forward(Axis::X));
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn is_forward(&self, axis: Axis<N>) -> bool {
        self.group.is_forward(axis.number())
    }

    /// Whether any axis has a travel without an end.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, AxisLimits::DEFAULT.order(Travel::Endless(true)))])?;
    /// assert!(motors.any_endless());
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn any_endless(&self) -> bool {
        self.group.any_endless()
    }

    /// Stops all axes at once, between two steps, and forgets the prepared orders. The position of
    /// a motor that moved becomes unknown.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, order)])?;
    /// motors.kill();
    /// assert!(!motors.any_moving());
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn kill(&mut self) {
        self.group.cancel();
        self.group.kill(&mut self.engine, Axes::MAX);
    }

    /// Stops these axes at once, between two steps, at a limit switch. Their positions are those of
    /// their last steps and stay known.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, order)])?;
    /// motors.kill_at_switch(Axis::X);
    /// assert!(!motors.any_moving() && motors.position(Axis::X).is_some());
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn kill_at_switch(&mut self, axes: impl Into<AxisSet<N>>) {
        self.group.kill_at_switch(&mut self.engine, axes.into().bits());
    }

    /// Marks all positions as unknown, because something else may have moved the motors.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.mark_positions_unknown();
    /// assert_eq!(motors.position(Axis::X), None);
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn mark_positions_unknown(&mut self) {
        self.group.mark_positions_unknown();
    }

    /// The axes whose position is unknown; bits beyond N may be set.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.mark_positions_unknown();
    /// motors.zero(Axis::X);
    /// assert_eq!(motors.uncertain() & 0b111, 0b110);
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn uncertain(&self) -> Axes {
        self.group.uncertain()
    }

    /// Sets the position of an axis at rest to 0.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.zero(Axis::X);
    /// assert_eq!(motors.position(Axis::X), Some(0));
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn zero(&mut self, axis: Axis<N>) {
        self.group.zero(&mut self.engine, axis.number());
    }

    /// Does one piece of planning, at most 200 µs on a 16 MHz AVR, or 0.7 ms with a jerk limit:
    /// a part of one run, for the axis whose queue runs out first, or the start of axes that wait for their queues. Returns true if
    /// there may be more to do. Call it until it returns false, at least every millisecond.
    #[inline(always)]
    pub fn plan(&mut self) -> bool {
        let more = self.group.poll(&mut self.engine);
        self.engine.refill();
        more
    }

    /// Counts this many ticks, since the last call, as rest of the axes at rest: see
    /// [`Steppers::count_rest`](crate::Steppers::count_rest).
    #[inline(always)]
    pub fn count_rest(&mut self, ticks: Ticks) {
        self.group.pass(&self.engine, ticks);
    }

    /// Whether an axis moves or is about to move.
    #[inline(always)]
    pub fn is_moving(&self, axis: Axis<N>) -> bool {
        self.group.is_busy(&self.engine, axis.number())
    }

    /// Whether any axis moves.
    #[inline(always)]
    pub fn any_moving(&self) -> bool {
        self.group.any_busy(&self.engine)
    }

    /// The position in steps, also during a move; `None` if it is unknown.
    #[inline(always)]
    pub fn position(&self, axis: Axis<N>) -> Option<i64> {
        self.group.position(&self.engine, axis.number())
    }

    /// The number of late steps of all axes since they were [cleared](OrderedMotors::clear_late).
    #[inline(always)]
    pub fn late(&self) -> u32 {
        self.engine.late()
    }

    /// Sets the number of late steps to 0.
    #[inline(always)]
    pub fn clear_late(&mut self) {
        self.engine.clear_late();
    }

    /// The board.
    pub fn board(&self) -> &Board<N, ()> {
        self.group.board()
    }

    /// Sets the drivers' times, in ticks: the length of the STEP pulse, and the set-up and hold
    /// time of DIR. Call it while all axes are at rest.
    #[inline(always)]
    pub fn set_drivers(&mut self, pulse: Ticks, setup: Ticks, hold: Ticks) {
        let board = self.group.board_mut();
        board.set_drivers(pulse, setup, hold);
        let timing = board.timing;
        self.engine.set_timing(timing);
    }

    /// The engine, or the handle to it.
    #[inline(always)]
    pub fn engine(&mut self) -> &mut E {
        &mut self.engine
    }
}
