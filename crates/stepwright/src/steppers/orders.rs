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
    /// [`Refusal`]; then [`cancel`](Steppers::cancel) what was prepared before.
    #[inline(always)]
    pub fn prepare(&mut self, axis: Axis<N>, order: &Order) -> Result<(), Refusal> {
        self.group.prepare(&mut self.engine, axis.number(), order)
    }

    /// Does one piece of starting what was prepared, to be called until it is ready. It
    /// starts `wait` ticks later than it could.
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
    /// [`Refusal`], and nothing moves; then [`cancel`](Steppers::cancel) it.
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

    /// Forgets what was prepared; a motor that moves goes on.
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

    /// Changes the travels that these axes are on, all or none: see [`Change`].
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
    /// [`Refusal`], and all goes on as it was.
    #[inline(always)]
    pub fn change(&mut self, axes: impl Into<AxisSet<N>>, change: Change) -> Result<(), Refusal> {
        self.group.change(&mut self.engine, axes.into().bits(), change)
    }

    /// Brakes one axis along its ramp: [`stop`](Steppers::stop) for a set of one.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, order)])?;
    /// motors.brake(Axis::X);
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn brake(&mut self, axis: Axis<N>) {
        self.group.brake(axis.number());
    }

    /// Whether a target this many steps from where the travel of an axis began lies forward
    /// of where that is planned to.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, order)])?;
    /// assert!(motors.leads_forward(Axis::X, 3_000));
    /// assert!(!motors.leads_forward(Axis::X, -1));
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn leads_forward(&self, axis: Axis<N>, target: i32) -> bool {
        self.group.leads_forward(axis.number(), target)
    }

    /// Where the part of a travel that is planned leads to, in steps from where it began: a
    /// change takes hold there. `None` if that is more than 2³¹ steps away.
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

    /// Whether the last or present travel of an axis leads forward, as far as it is planned.
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

    /// Whether any axis goes on until it is stopped.
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

    /// Stops all axes between two steps. The position of a motor that moved is not known
    /// from now on.
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
        self.group.kill(&mut self.engine);
    }

    /// Stops these axes between two steps, at a switch: their positions stay known, as far
    /// as the steps tell.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.start([(Axis::X, order)])?;
    /// motors.halt_at_switch(Axis::X);
    /// assert!(!motors.any_moving() && motors.position(Axis::X).is_some());
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn halt_at_switch(&mut self, axes: impl Into<AxisSet<N>>) {
        self.group.halt(&mut self.engine, axes.into().bits());
    }

    /// Calls all positions unknown: something else may have moved the motors.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.doubt();
    /// assert_eq!(motors.position(Axis::X), None);
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn doubt(&mut self) {
        self.group.doubt();
    }

    /// Axes whose position is not known; bits beyond N may be set.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, Change, Refusal, Speed, Travel};
    /// # use stepwright_sim::{Description, Queues, VirtualBoard};
    /// # let mut queues = Queues::default();
    /// # let mut board = VirtualBoard::<u16, _>::new(&mut queues, Description::uno(), ());
    /// # let motors = board.motors();
    /// # let order = AxisLimits::DEFAULT.order(Travel::By(2_000));
    /// motors.doubt();
    /// motors.zero(Axis::X);
    /// assert_eq!(motors.uncertain() & 0b111, 0b110);
    /// # Ok::<(), Refusal>(())
    /// ```
    #[inline(always)]
    pub fn uncertain(&self) -> Axes {
        self.group.uncertain()
    }

    /// Calls the present position of an axis at rest 0.
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
}
