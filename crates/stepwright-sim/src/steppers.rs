//! Motors in the virtual board's engine, without its line, settings and switches.

use stepwright::drive::Axes;
use stepwright::queue::Producer;
use stepwright::timer::Count;
use stepwright::{Board, Control, Engine, Playing, Report, Steppers, Ticks, Timing};

use crate::board::{AXES, BoardEngine, Queues, RUNS, Shared};
use crate::clock::{LentNow, Present, SimTimer};
use crate::description::Description;
use crate::edge::Recorder;
use crate::pins::Pins;

/// Three motors that a program moves on simulated pins, in simulated time.
pub type VirtualSteppers<'q, R, C = u16> = Steppers<'q, SimEngine<'q, R, C>, AXES, RUNS>;

/// Motors on a board with this description. Their edges go to `recorder`: a `Vec<Edge>`, or `()`.
///
/// ```
/// use stepwright::Axis;
/// use stepwright_sim::{Description, Edge, Queues, virtual_steppers};
/// let mut queues = Queues::default();
/// let mut motors = virtual_steppers(&mut queues, Description::uno(), Vec::<Edge>::new());
/// motors.move_to(Axis::Y, -3)?;
/// while motors.is_moving(Axis::Y) {
///     motors.poll();
///     motors.engine().pass(16_000);
/// }
/// assert_eq!(motors.position(Axis::Y), Some(-3));
/// assert_eq!(motors.engine().recorder().iter().filter(|edge| edge.is_step()).count(), 3);
/// # Ok::<(), stepwright::MoveError>(())
/// ```
pub fn virtual_steppers<R: Recorder>(
    queues: &mut Queues,
    description: Description,
    recorder: R,
) -> VirtualSteppers<'_, R> {
    virtual_steppers_of::<u16, R>(queues, description, recorder)
}

/// [`virtual_steppers`] with a timer of another width: `u32` for 32 bits.
///
/// ```
/// use stepwright_sim::{Description, Queues, virtual_steppers_of};
/// let mut queues = Queues::default();
/// let mut motors = virtual_steppers_of::<u32, _>(&mut queues, Description::uno(), ());
/// motors.move_to(stepwright::Axis::X, 1)?;
/// # Ok::<(), stepwright::MoveError>(())
/// ```
pub fn virtual_steppers_of<C: Count, R: Recorder>(
    queues: &mut Queues,
    description: Description,
    recorder: R,
) -> VirtualSteppers<'_, R, C> {
    let (engine, feeds, board) = virtual_engine(queues, description, recorder);
    Steppers::new(engine, feeds, board)
}

/// The parts for [`Steppers::new`] and the like: the engine of a board with this description, the feeds of its
/// queues, and the board.
///
/// ```
/// use stepwright::Steppers;
/// use stepwright_sim::{Description, Queues, virtual_engine};
/// let mut queues = Queues::default();
/// let (engine, feeds, board) = virtual_engine::<u32, _>(&mut queues, Description::uno(), ());
/// let motors = Steppers::new(engine, feeds, board);
/// assert!(!motors.any_moving());
/// ```
pub fn virtual_engine<C: Count, R: Recorder>(
    queues: &mut Queues,
    description: Description,
    recorder: R,
) -> (SimEngine<'_, R, C>, [Producer<'_, RUNS>; AXES], Board<AXES>) {
    let board = description.board;
    let Shared { ends: [x, y, z], now, reverse } = queues.lend(&description);
    let pins = Pins::new(now, reverse, &description.coils, recorder);
    let timer = SimTimer::on_grid(now, description.grid);
    let engine = Engine::new(timer, pins, [x.1, y.1, z.1], board.timing, board.rate);
    (SimEngine::new(now, engine), [x.0, y.0, z.0], board)
}

/// The engine of motors on simulated pins. Time passes only in [`pass`](SimEngine::pass).
pub struct SimEngine<'q, R: Recorder, C: Count = u16> {
    now: LentNow<'q>,
    engine: BoardEngine<'q, C, R>,
}

impl<'q, R: Recorder, C: Count> SimEngine<'q, R, C> {
    pub(crate) fn new(now: LentNow<'q>, engine: BoardEngine<'q, C, R>) -> Self {
        SimEngine { now, engine }
    }

    /// The present, in ticks since the board was switched on.
    pub fn now(&self) -> u64 {
        self.now.get()
    }

    /// Lets this many ticks pass, with all events up to and at the end.
    pub fn pass(&mut self, ticks: Ticks) {
        let end = self.now.get().saturating_add(ticks.into());
        while self.next_event() <= end {
            self.serve();
        }
        self.now.set(end.max(self.now.get()));
    }

    /// Lets time pass as a processor that sleeps does: until the step interrupt has news for the main loop, and
    /// this many ticks at most. Returns whether there was news.
    pub fn sleep(&mut self, most: Ticks) -> bool {
        let end = self.now.get().saturating_add(most.into());
        while self.next_event() <= end {
            if self.serve() {
                return true;
            }
        }
        self.now.set(end.max(self.now.get()));
        false
    }

    /// The next match of the compare register.
    pub(crate) fn next_event(&mut self) -> u64 {
        self.engine.timer().wake()
    }

    /// Runs the step interrupt, on time or late by a pulse. Returns whether it has news for the main loop.
    pub(crate) fn serve(&mut self) -> bool {
        let time = self.next_event();
        self.now.set(time.max(self.now.get()));
        self.engine.on_compare()
    }

    /// Sets DIR of all axes to their present directions.
    pub(crate) fn face(&mut self) {
        self.engine.drive().face();
    }

    /// The recorder.
    pub fn recorder(&mut self) -> &mut R {
        &mut self.engine.drive().recorder
    }
}

impl<R: Recorder, C: Count> Control for SimEngine<'_, R, C> {
    fn start(&mut self, axes: Axes) {
        self.engine.start(axes);
    }
    fn kill(&mut self, axes: Axes) {
        self.engine.kill(axes);
    }
    fn report(&self, axis: u8) -> Report {
        self.engine.report(axis)
    }
    fn playing(&mut self, axis: u8) -> Playing {
        self.engine.playing(axis)
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
}
