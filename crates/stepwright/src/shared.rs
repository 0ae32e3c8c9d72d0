//! An engine that an interrupt plays and the main loop orders about.

use core::cell::RefCell;

use critical_section::Mutex;

use crate::control::Control;
use crate::drive::{Axes, Drive};
use crate::engine::{Engine, Playing, Report, Timing};
use crate::queue::Source;
use crate::timer::StepTimer;

/// A place for an engine, for a static that the step interrupt and the main loop share.
///
/// Each call holds interrupts off for the microseconds that it takes, by the crate
/// `critical-section`, of which the program chooses the implementation of its chip.
///
/// ```
/// # use critical_section as _;
/// use stepwright::queue::Consumer;
/// use stepwright::{Axis, Control, Engine, MoveError, SharedEngine, Steppers};
/// # use stepwright::{Board, Rate, drive::Drive, queue::Producer, timer::StepTimer};
/// # struct Timer;
/// # impl StepTimer for Timer {
/// #     type Count = u32;
/// #     const LINGER: u32 = 0;
/// #     fn now(&mut self) -> u32 { 0 }
/// #     fn wake_at(&mut self, _: u32) {}
/// # }
/// # struct Pins;
/// # impl Drive for Pins {
/// #     fn begin(&mut self, _: u8) {}
/// #     fn end(&mut self, _: u8) {}
/// #     fn direction(&mut self, _: u8, _: bool) {}
/// # }
///
/// static ENGINE: SharedEngine<Engine<Timer, Pins, Consumer<'static, 8>, 1>> = SharedEngine::empty();
///
/// // The timer's interrupt.
/// fn on_compare() {
///     ENGINE.on_compare();
/// }
/// # fn main_loop(timer: Timer, pins: Pins, feed: Producer<'static, 8>, entries: Consumer<'static, 8>) -> Result<(), MoveError> {
///
/// // The main function, with a queue's two ends.
/// let board = Board::unmeasured(Rate::MHZ);
/// let engine = ENGINE.fill(Engine::new(timer, pins, [entries], board.timing, board.rate));
/// let mut motors = Steppers::new(engine, [feed], board);
/// motors.move_to(Axis::X, 400)?;
/// # Ok(())
/// # }
/// ```
pub struct SharedEngine<E>(Mutex<RefCell<Option<E>>>);

impl<E> SharedEngine<E> {
    /// No engine yet: its interrupt does nothing.
    pub const fn empty() -> SharedEngine<E> {
        SharedEngine(Mutex::new(RefCell::new(None)))
    }

    /// Puts an engine in. Returns the main loop's hold on it, for
    /// [`Steppers`](crate::Steppers). An engine that was there before is dropped.
    pub fn fill(&self, engine: E) -> EngineHandle<'_, E> {
        critical_section::with(|section| self.0.borrow(section).replace(Some(engine)));
        EngineHandle(self)
    }

    /// Calls `f` with the engine, and interrupts held off; `None` if there is none, or `f` of
    /// another call has it.
    fn with<R>(&self, f: impl FnOnce(&mut E) -> R) -> Option<R> {
        critical_section::with(|section| {
            self.0.borrow(section).try_borrow_mut().ok()?.as_mut().map(f)
        })
    }
}

impl<T: StepTimer, D: Drive, S: Source, const N: usize> SharedEngine<Engine<T, D, S, N>> {
    /// The step interrupt: see [`Engine::on_compare`].
    pub fn on_compare(&self) {
        self.with(Engine::on_compare);
    }
}

/// The main loop's hold on a [`SharedEngine`] that has been filled.
pub struct EngineHandle<'a, E>(&'a SharedEngine<E>);

impl<E: Control> Control for EngineHandle<'_, E> {
    fn start(&mut self, axes: Axes) {
        self.0.with(|engine| engine.start(axes));
    }
    fn kill(&mut self, axes: Axes) {
        self.0.with(|engine| engine.kill(axes));
    }
    fn report(&self, axis: u8) -> Report {
        let none = Report { position: 0, idle: true, forward: true };
        self.0.with(|engine| engine.report(axis)).unwrap_or(none)
    }
    fn playing(&mut self, axis: u8) -> Playing {
        self.0.with(|engine| engine.playing(axis)).unwrap_or(Playing::Unknown)
    }
    fn set_position(&mut self, axis: u8, position: i64) {
        self.0.with(|engine| engine.set_position(axis, position));
    }
    fn set_timing(&mut self, timing: Timing) {
        self.0.with(|engine| engine.set_timing(timing));
    }
    fn late(&self) -> u32 {
        self.0.with(|engine| engine.late()).unwrap_or(0)
    }
    fn clear_late(&mut self) {
        self.0.with(Control::clear_late);
    }
    fn refill(&mut self) {
        self.0.with(Control::refill);
    }
}
