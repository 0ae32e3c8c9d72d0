//! The step interrupt, and the foreground's way to hold it off.

use core::mem::MaybeUninit;

use avr_device::interrupt;
use stepwright::drive::Axes;
use stepwright::queue::{Consumer, Producer, Queue};
use stepwright::{Control, Engine, Report, Timing};

use crate::board::{AXES, Pins};
use crate::slot::Slot;
use crate::timer::Timer;

/// Runs queued for each axis, 12 bytes each.
pub const RUNS: usize = 8;

/// The engine that the step interrupt plays.
pub type StepEngine = Engine<Timer, Pins, Consumer<'static, RUNS>, AXES>;

/// Where the runs of all axes go.
pub type Feeds = [Producer<'static, RUNS>; AXES];

/// Split once, by `start`.
#[doc(hidden)] // the step interrupt reads it
pub static QUEUES: Slot<[Queue<RUNS>; AXES]> = Slot::new([const { Queue::new() }; AXES]);

/// Written once, by `start`, before interrupts are enabled; from then on the
/// step interrupt's.
#[doc(hidden)] // the step interrupt plays it
pub static ENGINE: Slot<MaybeUninit<StepEngine>> = Slot::new(MaybeUninit::uninit());

/// What the short way through the step interrupt leaves to the engine;
/// [`step_interrupt!`](crate::step_interrupt) has it called.
#[doc(hidden)]
pub extern "C" fn long_way(look: u16) {
    // SAFETY: only the step interrupt calls it, once there is an engine; the
    // foreground gets the engine only with interrupts off.
    unsafe { ENGINE.get().assume_init_mut() }.on_long_way(look);
}

/// Makes the engine. Returns the foreground's hold on it, and where its runs
/// go.
///
/// # Safety
/// To be called once, with interrupts disabled.
#[inline(never)]
pub unsafe fn start(timer: Timer, pins: Pins, timing: Timing) -> (Held, Feeds) {
    // SAFETY: the only place where the queues are named, and called once.
    let [x, y, z] = unsafe { QUEUES.get() }.each_mut().map(Queue::split);
    // SAFETY: interrupts are disabled, and there is no engine yet.
    unsafe { ENGINE.get() }.write(Engine::off(timer, pins, [x.1, y.1, z.1], timing)).begin();
    (Held(()), [x.0, y.0, z.0])
}

/// The engine with its interrupt held off for each call: some microseconds.
pub struct Held(());

impl Held {
    #[inline(always)]
    fn with<R>(&self, ask: impl FnOnce(&mut StepEngine) -> R) -> R {
        interrupt::free(|_| {
            // SAFETY: `start` made this `Held` and the engine before it, and no
            // interrupt comes.
            ask(unsafe { ENGINE.get().assume_init_mut() })
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
        self.with(|engine| engine.report(axis))
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
