//! Motor cycles (stepper_h) on the chip: three motors, each with a program of its own, moved by the
//! step interrupt while the main loop does other work.
//!
//! The interrupt itself reads the programs, checks bounds and switches, and calls callbacks; so it
//! is compiled, and takes longer than the interrupt that plays planned runs: `board::cycle` has the
//! costs. For ramps at high rates use the controller, `step.rs`.

use avr_device::interrupt;
use stepwright::drive::Axes;
use stepwright_cycle::{
    Calibration, Clock, Cycle, CycleError, MachineIo, Motor, Program, Refusal, Switches,
};

use crate::board::{self, AXES, Levels, Pins};
use crate::chip;
use crate::console::Console;
use crate::slot::Slot;
use crate::slot::token;
use crate::timer::Timer;

/// Three motors with their switches and drivers.
pub type Motors = Cycle<'static, Timer, Pins, MotorIo, AXES>;

/// Set up by `start`, before interrupts are enabled; from then on owned by the step interrupt.
static MOTORS: Slot<Motors> = Slot::new(Cycle::off(
    // SAFETY: it takes no memory, and it is not used before `start`, whose caller has the right to
    // it.
    unsafe { token() },
    // SAFETY: as above.
    unsafe { token() },
    // SAFETY: as above.
    MotorIo { levels: unsafe { token() }, stand: Switches::NONE },
    [Motor::new(1, 1); AXES],
    Clock::Deadlines,
    board::cycle(),
));

/// The drivers' common enable pin, and the switches, one for each motor.
pub struct MotorIo {
    levels: Levels,
    stand: Switches,
}

impl MachineIo for MotorIo {
    #[inline(always)]
    fn switches(&mut self) -> Switches {
        // Low is closed.
        let closed = !self.levels.switches();
        Switches { min: closed & self.stand.min, max: closed & self.stand.max }
    }

    fn enable(&mut self, axes: Axes) {
        self.levels.set_enable(axes == 0); // on while it is low
    }
}

/// Takes the chip. Sets up three motors, at position 0, and a serial line of 115200 baud to print
/// to. `stand` says which motors have their switch at the minimum, and which at the maximum; the
/// other switches are ignored.
///
/// # Safety
/// To be called once, with interrupts off; it switches them on. The program needs a
/// [`cycle_interrupt!`](crate::cycle_interrupt).
#[inline(never)]
pub unsafe fn start(motors: [Motor; AXES], stand: Switches) -> (AvrEngine, Console) {
    // SAFETY: they are taken only here.
    let chip = unsafe { chip::Peripherals::steal() };
    #[cfg(feature = "uno")]
    let (pins, levels) = board::pins(chip.PORTD, chip.PORTB);
    #[cfg(feature = "mega")]
    let (pins, levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
    let _ = (pins, levels); // // the engine owns them from here on
    // SAFETY: called once.
    let _ = unsafe { Timer::start() };
    // SAFETY: interrupts are off.
    let cycle = unsafe { MOTORS.get() };
    cycle.begin();
    cycle.surroundings().stand = stand;
    for (axis, motor) in (0u8..).zip(motors) {
        // No cycle runs yet, and there are as many motors.
        let _ = cycle.set_motor(axis, motor);
    }
    let console = Console::start(chip.USART0, chip.TC0);
    // SAFETY: everything that an interrupt uses is set up.
    unsafe { interrupt::enable() };
    (AvrEngine(()), console)
}

/// The step interrupt, called by [`cycle_interrupt!`](crate::cycle_interrupt).
///
/// # Safety
/// Only for the step interrupt, once there are motors.
#[doc(hidden)]
#[inline(always)]
pub unsafe fn on_compare() {
    // SAFETY: the caller's promise; the foreground accesses them only with interrupts off.
    unsafe { MOTORS.get() }.on_compare();
}

/// The foreground's handle to the motors: each call holds off the step interrupt.
pub struct AvrEngine(());

impl AvrEngine {
    /// Calls `ask` with the [`Cycle`], for all its other methods.
    #[inline(always)]
    pub fn with<R>(&mut self, ask: impl FnOnce(&mut Motors) -> R) -> R {
        interrupt::free(|_| {
            // SAFETY: `start` made this `AvrEngine` and the motors before it, and no interrupt
            // comes.
            ask(unsafe { MOTORS.get() })
        })
    }

    /// See [`Cycle::prepare`].
    ///
    /// # Errors
    /// [`Refusal::Running`] while a cycle is in progress; [`Refusal::NoMotor`].
    #[inline(never)]
    pub fn prepare(&mut self, motor: u8, program: Program<'static>) -> Result<(), Refusal> {
        self.with(|motors| motors.prepare(motor, program, Calibration::None))
    }

    /// Starts all prepared motors together. They run without the main loop.
    ///
    /// # Errors
    /// See [`Cycle::start`].
    #[inline(never)]
    pub fn start(&mut self) -> Result<(), Refusal> {
        self.with(Cycle::start)
    }

    /// Whether a cycle is in progress.
    pub fn is_running(&mut self) -> bool {
        self.with(|motors| motors.is_running())
    }

    /// The position of a motor in its unit, also during motion; 0 if there is no such motor.
    #[inline(never)]
    pub fn position(&mut self, motor: u8) -> i64 {
        self.with(|motors| motors.position(motor)).unwrap_or(0)
    }

    /// The reason why a cycle was cancelled.
    pub fn error(&mut self) -> Option<CycleError> {
        self.with(|motors| motors.error())
    }
}

/// Puts the step interrupt of motor cycles into a program.
#[macro_export]
macro_rules! cycle_interrupt {
    () => {
        $crate::handler!(TIMER1_COMPA, TIMER1_COMPA, {
            // SAFETY: this is the step interrupt, which `start` lets come.
            unsafe { $crate::cycle::on_compare() }
        });
    };
}
