//! N motors that move in the background: the type that a program holds.

mod axis;
mod error;
mod limits;
mod line;
mod moves;

use core::mem::MaybeUninit;

use crate::board::Board;
use crate::control::Control;
use crate::group::PlannedBoard;
use crate::order::Refusal;
use crate::ordered::OrderedMotors;
use crate::queue::Producer;
use crate::units::Ticks;
pub use axis::{Axis, AxisSet};
pub use error::MoveError;
pub use limits::AxisLimits;

/// The most pieces of planning that make a run.
const PIECES: u8 = 4;

/// N motors, each with its limits and a position of 64 bits.
///
/// Made of an engine or a handle to one in an interrupt (`E`, a [`Control`]), the feeds of the
/// engine's queues (`Q` runs each) and the board. A board-support crate and the virtual board make
/// one in a line.
///
/// A move continues in the background: the step interrupt makes the steps, and
/// [`poll`](Steppers::poll), called in the main loop, plans ahead. No step comes before the first
/// call: a loop that waits for the end of a move MUST call it. A call either does all that was
/// asked or returns an error before anything moves.
///
/// | to | call |
/// | --- | --- |
/// | set the limits of an axis | [`set_limits`](Steppers::set_limits) |
/// | move to a position, by a distance, along a line | [`move_to`](Steppers::move_to), [`move_by`](Steppers::move_by), [`move_line_to`](Steppers::move_line_to) |
/// | turn until stopped | [`run`](Steppers::run) |
/// | change a move in progress | [`retarget`](Steppers::retarget), [`set_top_speed`](Steppers::set_top_speed), [`set_acceleration`](Steppers::set_acceleration), [`set_deceleration`](Steppers::set_deceleration) |
/// | stop along the ramp, or at once | [`stop`](Steppers::stop), [`kill`](Steppers::kill) |
/// | read the position, and the distance left | [`position`](Steppers::position), [`distance_to_go`](Steppers::distance_to_go), [`is_moving`](Steppers::is_moving) |
///
/// Positions are in steps, as the driver counts them; speeds in steps/s.
///
/// ```
/// use stepwright::{Accel, Axis, AxisLimits, Control, MoveError, Speed, Steppers};
///
/// fn there_and_back(motors: &mut Steppers<'_, impl Control, 3>) -> Result<(), MoveError> {
///     let limits = AxisLimits::new(Speed::of::<4_000>(), Accel::of::<10_000>());
///     motors.set_limits(Axis::X, limits);
///     for target in [16_000, 0] {
///         motors.move_to(Axis::X, target)?;
///         while motors.is_moving(Axis::X) {
///             motors.poll();
///             // The main loop is free for other work.
///         }
///     }
///     Ok(())
/// }
/// ```
///
/// Where each order has its own limits, as on a serial line, see [`OrderedMotors`].
pub struct Steppers<'q, E, const N: usize, const Q: usize = 8> {
    motors: OrderedMotors<'q, E, N, Q>,
    axes: [Limited; N],
}

/// An axis: its limits, and its present travel.
#[derive(Clone, Copy, Debug)]
struct Limited {
    limits: AxisLimits,
    /// Where the present or last travel began.
    origin: i64,
}

impl Limited {
    const INITIAL: Limited = Limited { limits: AxisLimits::DEFAULT, origin: 0 };
}

impl<'q, E: Control, const N: usize, const Q: usize> Steppers<'q, E, N, Q> {
    /// All motors at rest at position 0, with [`AxisLimits::DEFAULT`].
    ///
    /// `feeds` MUST be the feeds of the engine's queues, in the order of its axes.
    pub const fn new(engine: E, feeds: [Producer<'q, Q>; N], board: Board<N>) -> Self {
        let motors = OrderedMotors::new(engine, feeds, board);
        Steppers { motors, axes: [Limited::INITIAL; N] }
    }

    /// Motors before power-up, for a static on a chip: all zeros except the engine, so they take no
    /// flash and are not moved over the stack.
    ///
    /// # Safety
    /// Before [`power_up`](Steppers::power_up) no method may be called except
    /// [`engine`](Steppers::engine).
    pub const unsafe fn blank(engine: E) -> Self {
        // SAFETY: zeros are valid limits and origins: numbers, and an option of a number. The
        // caller promises the rest.
        unsafe {
            let axes = MaybeUninit::zeroed().assume_init();
            Steppers { motors: OrderedMotors::blank(engine), axes }
        }
    }

    /// Initialises [blank](Steppers::blank) motors as [`new`](Steppers::new) does. `feed` writes
    /// the feed of an axis, `fill` the board.
    #[inline(always)]
    pub fn power_up(
        &mut self,
        feed: impl FnMut(u8, &mut Producer<'q, Q>),
        fill: impl FnOnce(&mut PlannedBoard<N>),
    ) {
        self.motors.power_up(feed, fill);
        self.axes = [Limited::INITIAL; N];
    }

    /// Plans ahead; call it in the main loop. Returns the ticks of the step timer after which it
    /// must be called again at the latest: 0 for at once, `None` for not before the next order.
    ///
    /// A call plans at most one run: some 7,000 cycles on a 16 MHz AVR, 0.4 ms, or 20,000 and more
    /// with a jerk limit.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// // The main loop of a program that can sleep.
    /// match motors.poll() {
    ///     Some(0) => {} // call it again
    ///     Some(_ticks) => { /* sleep for as long, or until an input changes */ }
    ///     None => { /* sleep until there is something to move */ }
    /// }
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn poll(&mut self) -> Option<Ticks> {
        for _ in 0..PIECES {
            if !self.plan() {
                let OrderedMotors { group, engine } = &mut self.motors;
                return group.may_wait(engine);
            }
        }
        Some(0)
    }

    /// Does one piece of planning, at most 200 µs on a 16 MHz AVR, or 0.7 ms with a jerk limit:
    /// a part of one run, for the axis whose queue runs out first. Returns true if there may be more to do.
    /// [`poll`](Steppers::poll) makes several of these calls.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.move_by(Axis::X, 200)?;
    /// while motors.plan() {} // all that is wanted now; `poll` does as much
    /// # Ok::<(), MoveError>(())
    /// ```
    #[inline(always)]
    pub fn plan(&mut self) -> bool {
        self.motors.plan()
    }

    /// Counts this many ticks, since the last call, as rest of the axes at rest.
    ///
    /// Two moves of an axis are one interval of its start speed apart, or from rest √(2/a): 14 ms
    /// at 10,000 steps/s², but a second at 2 steps/s², and half a minute after a line in which the
    /// axis made a few steps. [`poll`](Steppers::poll) knows no time: unless a program calls this
    /// every few milliseconds, the next move of the axis, and the axes that move with it, wait for
    /// all of that, however long the axis has been at rest. The axis is busy meanwhile, and a stop
    /// in that time leaves it one step.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.count_rest(16_000); // a millisecond of a 16 MHz timer
    /// motors.move_by(Axis::X, 200)?;
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn count_rest(&mut self, ticks: Ticks) {
        self.motors.count_rest(ticks);
    }

    /// Stops these axes along their ramps. Their positions stay known.
    ///
    /// Braking begins after the steps that are already planned, some 16 ms or the present step and the
    /// next one, if they take longer. An axis at rest stays at rest.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.run(Axis::X, 400)?;
    /// motors.stop(Axis::X | Axis::Z);
    /// while motors.is_moving(Axis::X) {
    ///     motors.poll();
    ///     # motors.engine().pass(16_000);
    /// }
    /// assert!(motors.position(Axis::X).is_some());
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn stop(&mut self, axes: impl Into<AxisSet<N>>) {
        for axis in axes.into().iter() {
            self.motors.stop(axis);
        }
    }

    /// Stops these axes at once, between two steps. A motor that moved may slip further, so its
    /// [`position`](Steppers::position) is unknown until it is set.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.run(Axis::X, 400)?;
    /// # for _ in 0..100 {
    /// #     motors.poll();
    /// #     motors.engine().pass(16_000);
    /// # }
    /// motors.kill(AxisSet::ALL);
    /// assert!(!motors.is_moving(Axis::X));
    /// assert_eq!(motors.position(Axis::X), None);
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn kill(&mut self, axes: impl Into<AxisSet<N>>) {
        let OrderedMotors { group, engine } = &mut self.motors;
        group.kill(engine, axes.into().bits());
    }

    /// Whether an axis moves or is about to move.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// assert!(!motors.is_moving(Axis::X));
    /// motors.move_by(Axis::X, 200)?;
    /// assert!(motors.is_moving(Axis::X) && !motors.is_moving(Axis::Y));
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn is_moving(&self, axis: Axis<N>) -> bool {
        self.motors.is_moving(axis)
    }

    /// Whether any axis moves.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.move_by(Axis::Z, 3)?;
    /// while motors.any_moving() {
    ///     motors.poll();
    ///     # motors.engine().pass(16_000);
    /// }
    /// assert_eq!(motors.position(Axis::Z), Some(3));
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn any_moving(&self) -> bool {
        self.motors.any_moving()
    }

    /// The position in steps, also during a move. `None` if it is unknown: after a
    /// [`kill`](Steppers::kill) during a move, or after [`mark_unknown`](Steppers::mark_unknown).
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// assert_eq!(motors.position(Axis::X), Some(0));
    /// motors.move_by(Axis::X, -2)?;
    /// while motors.is_moving(Axis::X) {
    ///     motors.poll();
    ///     # motors.engine().pass(16_000);
    /// }
    /// assert_eq!(motors.position(Axis::X), Some(-2));
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn position(&self, axis: Axis<N>) -> Option<i64> {
        self.motors.position(axis)
    }

    /// Sets the position of an axis at rest.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.set_position(Axis::X, 0)?;
    /// assert_eq!(motors.position(Axis::X), Some(0));
    /// # Ok::<(), MoveError>(())
    /// ```
    ///
    /// # Errors
    /// [`Refusal::Busy`](crate::Refusal::Busy) while the axis moves.
    pub fn set_position(&mut self, axis: Axis<N>, position: i64) -> Result<(), MoveError> {
        self.must_rest(axis)?;
        let OrderedMotors { group, engine } = &mut self.motors;
        group.set_position(engine, axis.number(), position);
        Ok(())
    }

    /// Marks the positions of these axes as unknown, after a motor has stalled or its driver was
    /// disabled. A moving axis continues; [`stop`](Steppers::stop) it as well.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.mark_unknown(Axis::Y);
    /// assert_eq!((motors.position(Axis::X), motors.position(Axis::Y)), (Some(0), None));
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn mark_unknown(&mut self, axes: impl Into<AxisSet<N>>) {
        self.motors.group.mark_unknown(axes.into().bits());
    }

    /// The number of late steps of all axes since they were [cleared](Steppers::clear_late). Steps
    /// are late when the main loop calls `poll` too rarely, or when other interrupts take too long.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.run(Axis::X, 400)?;
    /// # for _ in 0..1_000 {
    /// #     motors.poll();
    /// #     motors.engine().pass(16_000);
    /// # }
    /// assert_eq!(motors.late(), 0);
    /// # motors.engine().pass(16_000_000);
    /// // The main loop is away for a second.
    /// assert!(motors.late() > 0);
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn late(&self) -> u32 {
        self.motors.late()
    }

    /// Sets the number of late steps to 0.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.clear_late();
    /// assert_eq!(motors.late(), 0);
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn clear_late(&mut self) {
        self.motors.clear_late();
    }

    /// The board.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// assert_eq!(motors.board().rate.hz(), 16_000_000);
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn board(&self) -> &Board<N, ()> {
        self.motors.board()
    }

    /// Sets the drivers' times from now on, in ticks: the length of the STEP pulse, and the set-up
    /// and hold time of DIR. Call it while all axes are at rest.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// // 3 µs, 0.7 µs and 0.7 µs.
    /// let rate = motors.board().rate;
    /// motors.set_drivers(rate.nanos(3_000), rate.nanos(700), rate.nanos(700));
    /// assert_eq!(motors.board().timing.pulse, 48);
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn set_drivers(&mut self, pulse: Ticks, setup: Ticks, hold: Ticks) {
        self.motors.set_drivers(pulse, setup, hold);
    }

    /// The engine, or the handle to it.
    ///
    /// ```
    /// # use stepwright::{Axis, AxisLimits, AxisSet, MoveError};
    /// # use stepwright_sim::{Description, Queues, virtual_steppers};
    /// # let mut queues = Queues::default();
    /// # let mut motors = virtual_steppers(&mut queues, Description::uno(), ());
    /// motors.engine().pass(16_000); // a simulated engine: a millisecond passes
    /// # Ok::<(), MoveError>(())
    /// ```
    pub fn engine(&mut self) -> &mut E {
        self.motors.engine()
    }

    fn must_rest(&self, axis: Axis<N>) -> Result<(), MoveError> {
        if self.is_moving(axis) { Err(Refusal::Busy.into()) } else { Ok(()) }
    }
}
