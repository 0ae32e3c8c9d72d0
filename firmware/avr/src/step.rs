//! The step interrupt, and the foreground's way to hold it off.

use core::mem::MaybeUninit;

use avr_device::interrupt;
use stepwright::drive::Axes;
use stepwright::queue::{Consumer, Producer, Queue};
use stepwright::{Control, Engine, Report, Timing};

use crate::board::{AXES, Pins, description};
use crate::slot::Slot;
use crate::timer::Timer;

/// Runs queued for each axis, 13 bytes each.
pub const RUNS: usize = 8;

/// The engine that the step interrupt plays.
pub type StepEngine = Engine<Timer, Pins, Consumer<'static, RUNS>, AXES>;

/// Where the runs of all axes go.
pub type Feeds = [Producer<'static, RUNS>; AXES];

/// Shared by the engine and the foreground.
#[doc(hidden)] // the step interrupt reads it
pub static QUEUES: Slot<[Queue<RUNS>; AXES]> = Slot::new([const { Queue::new() }; AXES]);

/// The ends of an axis's queue.
///
/// # Safety
/// Each end is for one user: the first for that of [`feeds`], the second for the engine.
const unsafe fn ends(axis: usize) -> (Producer<'static, RUNS>, Consumer<'static, RUNS>) {
    // SAFETY: the caller's promise; a queue is shared as it is.
    unsafe { QUEUES.share()[axis].ends() }
}

/// Begun by `start`, before interrupts are enabled; from then on the step
/// interrupt's.
///
/// Its memory is filled when the chip starts: code that does it would be longer.
#[doc(hidden)] // the step interrupt plays it
pub static ENGINE: Slot<StepEngine> = Slot::new(Engine::off(
    // SAFETY: they take no memory, and the engine does nothing before `start`,
    // whose caller has the right to them.
    unsafe { token() },
    unsafe { token() },
    // SAFETY: the engine's ends.
    unsafe { [ends(0).1, ends(1).1, ends(2).1] },
    description().timing,
));

/// Registers, which are no more than a right.
///
/// # Safety
/// The caller has the right, or nothing is done with them before somebody has.
pub(crate) const unsafe fn token<T>() -> T {
    const { assert!(size_of::<T>() == 0) };
    // SAFETY: of a value without bytes none is missing; the caller's promise.
    unsafe { MaybeUninit::uninit().assume_init() }
}

/// What the short way through the step interrupt leaves to the engine;
/// [`step_interrupt!`](crate::step_interrupt) has it called.
///
/// # Safety
/// For the step interrupt alone, once there is an engine.
#[doc(hidden)]
pub unsafe extern "C" fn long_way(look: u16) {
    // SAFETY: the caller's promise; the foreground gets the engine only with
    // interrupts off.
    unsafe { ENGINE.get() }.on_long_way(look);
}

/// Has the engine begin. Returns the foreground's hold on it.
///
/// # Safety
/// To be called once, with interrupts disabled.
pub unsafe fn start(_: Timer, _: Pins) -> Held {
    // SAFETY: interrupts are disabled.
    unsafe { ENGINE.get() }.begin();
    Held(())
}

/// Where the foreground's runs go.
///
/// # Safety
/// For one user: a queue has one producer.
pub const unsafe fn feeds() -> Feeds {
    // SAFETY: the caller's promise.
    unsafe { [ends(0).0, ends(1).0, ends(2).0] }
}

/// The engine with its interrupt held off for each call: some microseconds.
pub struct Held(());

impl Held {
    #[inline(always)]
    fn with<R>(&self, ask: impl FnOnce(&mut StepEngine) -> R) -> R {
        interrupt::free(|_| {
            // SAFETY: `start` made this `Held` and the engine before it, and no
            // interrupt comes.
            ask(unsafe { ENGINE.get() })
        })
    }
}

impl Control for Held {
    fn start(&mut self, axes: Axes) {
        self.with(|engine| engine.start(axes));
    }
    fn halt(&mut self, axes: Axes) {
        self.with(|engine| engine.halt(axes));
    }
    fn report(&self, axis: u8) -> Report {
        // SAFETY: `start` made this `Held`, and the engine is begun.
        unsafe { StepEngine::glimpse(ENGINE.address(), axis) }
    }
    fn is_idle(&self, axis: u8) -> bool {
        // SAFETY: `start` made this `Held`, and the engine is begun.
        unsafe { StepEngine::is_idle(ENGINE.address(), axis) }
    }
    fn position(&self, axis: u8) -> i64 {
        // SAFETY: `start` made this `Held`, and the engine is begun.
        unsafe { StepEngine::position(ENGINE.address(), axis) }
    }
    fn is_forward(&self, axis: u8) -> bool {
        // SAFETY: `start` made this `Held`, and the engine is begun.
        unsafe { StepEngine::is_forward(ENGINE.address(), axis) }
    }
    fn set_position(&mut self, axis: u8, position: i64) {
        self.with(|engine| engine.set_position(axis, position));
    }
    fn set_timing(&mut self, timing: Timing) {
        self.with(|engine| engine.set_timing(timing));
    }
    fn late(&self) -> u32 {
        self.with(|engine| engine.late())
    }
    fn clear_late(&mut self) {
        self.with(|engine| engine.clear_late());
    }
}
