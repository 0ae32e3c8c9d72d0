//! An engine for a planner without a clock, which only the news of the step interrupt wakes.

use crate::board::Board;
use crate::control::Control;
use crate::drive::Axes;
use crate::engine::{Playing, Report, Timing};
use crate::units::Ticks;

/// Wraps an engine, or a handle to one, for a planner that sleeps until an order comes or
/// [`Engine::on_compare`](crate::Engine::on_compare) reports news.
///
/// A planner that is called every few milliseconds queues nothing after a wait longer than its
/// [horizon](Board::horizon), so that a change takes effect there. A planner that is called only at
/// news would then plan too late, because the next news is the step itself. With this wrapper the
/// next step is always queued. In return, on an axis whose interval is longer than the horizon, 16
/// ms (slower than some 60 steps/s), a change takes effect one step later.
///
/// ```
/// # use stepwright::{Axis, Board, ByNews, MoveError, Steppers};
/// # use stepwright_sim::{Description, Queues, virtual_engine};
/// # let mut queues = Queues::default();
/// # let (engine, feeds, board) = virtual_engine::<u32, _>(&mut queues, Description::uno(), ());
/// let mut motors = Steppers::new(ByNews::new(engine, &board), feeds, board);
/// motors.run(Axis::X, 2)?;
/// for _ in 0..50 {
///     while motors.plan() {}
///     // Sleep until `on_compare` is true; here for a second at most, in simulated time.
///     motors.engine().inner().sleep(16_000_000);
/// }
/// assert_eq!(motors.late(), 0);
/// # Ok::<(), MoveError>(())
/// ```
pub struct ByNews<E> {
    engine: E,
    /// A present entry with this many ticks left or more counts as having none left: less than the
    /// horizon, by more than its rounding.
    far: Ticks,
}

impl<E: Control> ByNews<E> {
    /// Wraps the engine of a board.
    pub const fn new<const N: usize, F>(engine: E, board: &Board<N, F>) -> ByNews<E> {
        ByNews { engine, far: board.horizon - board.horizon / 8 }
    }

    /// The engine, or the handle to it.
    pub fn inner(&mut self) -> &mut E {
        &mut self.engine
    }
}

impl<E: Control> Control for ByNews<E> {
    fn start(&mut self, axes: Axes) {
        self.engine.start(axes);
    }
    fn kill(&mut self, axes: Axes) {
        self.engine.kill(axes);
    }
    fn report(&self, axis: u8) -> Report {
        self.engine.report(axis)
    }
    fn is_idle(&self, axis: u8) -> bool {
        self.engine.is_idle(axis)
    }
    fn position(&self, axis: u8) -> i64 {
        self.engine.position(axis)
    }
    fn is_forward(&self, axis: u8) -> bool {
        self.engine.is_forward(axis)
    }
    fn playing(&mut self, axis: u8) -> Playing {
        match self.engine.playing(axis) {
            Playing::Left(left) if left >= self.far => Playing::Left(0),
            Playing::Dry(left) if left >= self.far => Playing::Dry(0),
            near => near,
        }
    }
    fn set_position(&mut self, axis: u8, position: i64) {
        self.engine.set_position(axis, position);
    }
    fn set_timing(&mut self, timing: Timing) {
        self.engine.set_timing(timing);
    }
    fn late(&self) -> u32 {
        self.engine.late()
    }
    fn clear_late(&mut self) {
        self.engine.clear_late();
    }
    fn refill(&mut self) {
        self.engine.refill();
    }
}
