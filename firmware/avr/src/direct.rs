//! The step interrupt with the law in it, and the foreground's way to hold it off.

use avr_device::interrupt;
use stepwright::direct::{Direct, Ramp, Steering};
use stepwright::drive::Axes;
use stepwright::{Control, Engine, Report, Ticks, Timing};

use crate::board::{AXES, Pins, direct};
use crate::slot::Slot;
use crate::slot::token;
use crate::timer::Timer;

/// The engine that the step interrupt plays.
pub type DirectEngine = Engine<Timer, Pins, Direct, AXES>;

/// Begun by `start`, before interrupts are enabled; from then on the step
/// interrupt's.
#[doc(hidden)] // the step interrupt plays it
pub static ENGINE: Slot<DirectEngine> = Slot::new(Engine::off(
    // SAFETY: they take no memory, and the engine does nothing before `start`,
    // whose caller has the right to them.
    unsafe { token() },
    unsafe { token() },
    [Direct::IDLE; AXES],
    direct().timing,
));

/// What the direct way leaves to the engine;
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

/// The engine with its interrupt held off for each call: some microseconds.
pub struct Held(());

impl Held {
    #[inline(always)]
    fn with<R>(&self, ask: impl FnOnce(&mut DirectEngine) -> R) -> R {
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
        unsafe { DirectEngine::glimpse(ENGINE.address(), axis) }
    }
    fn is_idle(&self, axis: u8) -> bool {
        // SAFETY: `start` made this `Held`, and the engine is begun.
        unsafe { DirectEngine::is_idle(ENGINE.address(), axis) }
    }
    fn position(&self, axis: u8) -> i64 {
        // SAFETY: `start` made this `Held`, and the engine is begun.
        unsafe { DirectEngine::position(ENGINE.address(), axis) }
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

impl Steering for Held {
    fn begin(&mut self, axis: u8, forward: bool, hold: Ticks, lead: Ticks, ramp: Ramp) {
        // The axis rests: the interrupt does not look at its feed.
        self.with(|engine| Steering::begin(engine, axis, forward, hold, lead, ramp));
    }
    fn brake(&mut self, axis: u8) {
        self.with(|engine| Steering::brake(engine, axis));
    }
    fn go_on(&mut self, axis: u8) {
        self.with(|engine| engine.go_on(axis));
    }
}
