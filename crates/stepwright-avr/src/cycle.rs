//! Motor cycles (stepper_h) on the chip: three motors, each with a program of its own,
//! moved by the step interrupt while the main loop does as it likes.
//!
//! The interrupt reads the programs itself, bounds, switches and callbacks included; so it
//! is compiled, and takes longer than the one that plays planned runs: `board::cycle` has
//! the costs. Ramps at high rates are for the controller, `step.rs`.

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

/// Three motors and what is around them.
pub type Motors = Cycle<'static, Timer, Pins, MotorIo, AXES>;

/// Begun by `start`, before interrupts are enabled; from then on the step interrupt's.
static MOTORS: Slot<Motors> = Slot::new(Cycle::off(
    // SAFETY: it takes no memory, and nothing is done with it before `start`, whose caller
    // has the right to it.
    unsafe { token() },
    // SAFETY: as above.
    unsafe { token() },
    // SAFETY: as above.
    MotorIo { levels: unsafe { token() }, stand: Switches::NONE },
    [Motor::new(1, 1); AXES],
    Clock::Deadlines,
    board::cycle(),
));

/// The drivers' enable, which they share, and the switches, one for each motor.
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

/// Takes the chip, and makes three motors of it, at position 0, and a serial line of
/// 115200 baud to print to. `stand` says which motors have their switch at the minimum, and
/// which at the maximum; the other switches are not looked at.
///
/// # Safety
/// To be called once, with interrupts off, which are on afterwards; in a program with a
/// [`cycle_interrupt!`](crate::cycle_interrupt).
#[inline(never)]
pub unsafe fn start(motors: [Motor; AXES], stand: Switches) -> (AvrEngine, Console) {
    // SAFETY: the only time that anybody takes them.
    let chip = unsafe { chip::Peripherals::steal() };
    #[cfg(feature = "uno")]
    let (pins, levels) = board::pins(chip.PORTD, chip.PORTB);
    #[cfg(feature = "mega")]
    let (pins, levels) = board::pins(chip.PORTB, chip.PORTE, chip.PORTG, chip.PORTH);
    let _ = (pins, levels); // their right is the engine's from here on
    // SAFETY: called once.
    let _ = unsafe { Timer::start() };
    // SAFETY: interrupts are off.
    let cycle = unsafe { MOTORS.get() };
    cycle.begin();
    cycle.surroundings().stand = stand;
    for (axis, motor) in (0u8..).zip(motors) {
        // No cycle runs yet, and there are as many.
        let _ = cycle.set_motor(axis, motor);
    }
    let console = Console::start(chip.USART0, chip.TC0);
    // SAFETY: all that an interrupt touches has been made.
    unsafe { interrupt::enable() };
    (AvrEngine(()), console)
}

/// The step interrupt; [`cycle_interrupt!`](crate::cycle_interrupt) has it called.
///
/// # Safety
/// For the step interrupt alone, once there are motors.
#[doc(hidden)]
#[inline(always)]
pub unsafe fn on_compare() {
    // SAFETY: the caller's promise; the foreground gets them only with interrupts off.
    unsafe { MOTORS.get() }.on_compare();
}

/// The motors, for the foreground: the step interrupt is held off for each call.
pub struct AvrEngine(());

impl AvrEngine {
    /// All else that can be asked of a [`Cycle`].
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
    /// [`Refusal::Running`] while a cycle is; [`Refusal::NoMotor`].
    #[inline(never)]
    pub fn prepare(&mut self, motor: u8, program: Program<'static>) -> Result<(), Refusal> {
        self.with(|motors| motors.prepare(motor, program, Calibration::None))
    }

    /// Starts all motors that were prepared, together. They are in no need of the main
    /// loop.
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

    /// The position of a motor in its unit, also on the way; 0 if there is no such motor.
    #[inline(never)]
    pub fn position(&mut self, motor: u8) -> i64 {
        self.with(|motors| motors.position(motor)).unwrap_or(0)
    }

    /// Why a cycle was cancelled.
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
