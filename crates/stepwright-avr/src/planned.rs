//! Planned moves on any drive: `Steppers` of one motor, whose queue the portable engine plays.
//!
//! ```text
//!   move_to ─► planner ─► Queue ─► Engine in the interrupt of timer 1 ─► any drive
//! ```
//!
//! The step interrupt is compiled, for any [`Drive`]. Step and direction on the pins of a shield
//! are driven by assembly, for three motors and ten times as fast: [`steppers`](crate::steppers).
//! One line makes a motor from a drive: [`planned_motor!`](crate::planned_motor).

use core::mem::MaybeUninit;

use avr_device::interrupt;
use stepwright::drive::{Axes, Drive};
use stepwright::queue::{Consumer, Queue};
use stepwright::{Control, Engine, Playing, Report, Timing};

use crate::asked::Output;
use crate::board;
use crate::slot::Slot;
use crate::timer::Timer;

/// The runs that a queue holds.
const RUNS: usize = 8;
/// The cycles allowed for a step: the longest stay in the step interrupt that makes one step
/// (`firmware/rig/tests/drives.rs`), and a fifth more for the main loop.
const COST: u16 = 1_600;

/// The engine of one motor.
type MotorEngine<D> = Engine<Timer, D, Consumer<'static, RUNS>, 1>;

/// One motor, for a program.
pub type Motor<D> = stepwright::Steppers<'static, PlannedEngine<D>, 1, RUNS>;

/// A motor's static memory.
pub struct PlannedStore<D> {
    queue: Queue<RUNS>,
    engine: MaybeUninit<MotorEngine<D>>,
}

impl<D: Output> PlannedStore<D> {
    /// Memory without a motor.
    pub const fn new() -> PlannedStore<D> {
        PlannedStore { queue: Queue::new(), engine: MaybeUninit::uninit() }
    }

    /// Makes the motor, with its current on.
    ///
    /// # Safety
    /// To be called once, with interrupts off; `store` belongs to timer 1's interrupt.
    #[doc(hidden)]
    pub unsafe fn take(store: &'static Slot<PlannedStore<D>>, mut drive: D) -> Motor<D> {
        // SAFETY: the caller's promise.
        let PlannedStore { queue, engine } = unsafe { store.get() };
        let (feed, entries) = queue.split();
        let board = board::any_cycle::<1>(COST, COST.into());
        drive.on();
        // SAFETY: called once.
        let timer = unsafe { Timer::start() };
        engine.write(Engine::new(timer, drive, [entries], board.timing, board.rate));
        Motor::new(PlannedEngine(store), [feed], board)
    }

    /// The step interrupt.
    ///
    /// # Safety
    /// Only for that interrupt, once the motor is taken.
    #[doc(hidden)]
    #[inline(always)]
    pub unsafe fn on_compare(&mut self) {
        // SAFETY: `take` made it, with interrupts off.
        unsafe { self.engine.assume_init_mut() }.on_compare();
    }
}

/// The foreground's handle to the engine: each call holds off the step interrupt.
pub struct PlannedEngine<D: 'static>(&'static Slot<PlannedStore<D>>);

impl<D: Drive> PlannedEngine<D> {
    fn with<R>(&self, ask: impl FnOnce(&mut MotorEngine<D>) -> R) -> R {
        interrupt::free(|_| {
            // SAFETY: no interrupt comes, and `take` made both.
            ask(unsafe { self.0.get().engine.assume_init_mut() })
        })
    }

    /// Puts the motor on another drive. The motor must rest.
    pub fn rewire(&mut self, drive: D)
    where
        D: Output,
    {
        self.with(|engine| {
            engine.drive().off();
            *engine.drive() = drive;
            let forward = engine.report(0).forward;
            engine.drive().direction(0, forward);
            engine.drive().on();
        });
    }
}

impl<D: Drive> Control for PlannedEngine<D> {
    fn start(&mut self, axes: Axes) {
        self.with(|engine| engine.start(axes));
    }
    fn kill(&mut self, axes: Axes) {
        self.with(|engine| engine.kill(axes));
    }
    fn report(&self, axis: u8) -> Report {
        self.with(|engine| engine.report(axis))
    }
    fn playing(&mut self, axis: u8) -> Playing {
        // Steps need not be reported: the step interrupt is held off only for this check.
        if self.with(|engine| engine.waits(axis)) {
            self.with(|engine| engine.playing(axis))
        } else {
            Playing::Unknown
        }
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
        self.with(Engine::clear_late);
    }
}

/// Makes a module for a planned motor on timer 1, with a function that takes it, from a name and a
/// drive.
#[macro_export]
macro_rules! planned_motor {
    ($(#[$doc:meta])* mod $name:ident, $drive:ty) => {
        $(#[$doc])*
        mod $name {
            use super::*;
            use $crate::planned::{Motor, PlannedStore};
            use $crate::slot::Slot;

            static STORE: Slot<PlannedStore<$drive>> = Slot::new(PlannedStore::new());

            $crate::handler!(TIMER1_COMPA, TIMER1_COMPA, {
                // SAFETY: this is the interrupt that owns it; it comes once the motor is taken.
                unsafe { STORE.get().on_compare() }
            });

            /// Takes the motor, on this drive.
            ///
            /// # Safety
            /// To be called once, with interrupts off.
            pub unsafe fn take(drive: $drive) -> Motor<$drive> {
                // SAFETY: the caller's promise.
                unsafe { PlannedStore::take(&STORE, drive) }
            }
        }
    };
}
