//! The common part of the Arduino driver's validation cases: the console, and the main loop that
//! prints the debug dump.

use stepwright_timed::fit::Hardware;
use stepwright_timed::{Driver, Model, SetSpeed};

use super::{Windings, io_clock_now};
use crate::chip;
use crate::console::Console;

/// The time of the call in milliseconds, as in the logs.
pub const CALL: u32 = 1_009;
/// The time from the call to the first dump, and from one dump to the next.
const FIRST_DUMP: u32 = 167;
const EVERY: u32 = 1_001;

/// Starts the console and the interrupts, prints the first lines of the article's program, and
/// waits for the time of the call.
///
/// # Safety
/// To be called once, with interrupts off, when everything that they use is set up.
pub unsafe fn start(model: Model) -> (Console, Driver) {
    // SAFETY: they are taken only here.
    let chip = unsafe { chip::Peripherals::steal() };
    let mut console = Console::start(chip.USART0, chip.TC0);
    let clock = io_clock_now();
    // SAFETY: the caller's promise.
    unsafe { avr_device::interrupt::enable() };
    console.line("IRQ Timer 1 Enabled");
    console.text("Ioclk ");
    console.number(clock);
    console.line(" Hz");
    console.wait_until(CALL);
    (console, Driver::new(Hardware::avr16(clock), model))
}

/// Carries out an order by the step interrupt, prints the dump every second, and stops when the
/// motor has stopped.
///
/// # Safety
/// As [`start`].
pub unsafe fn logged(held: &mut impl Windings, order: &SetSpeed) -> ! {
    // SAFETY: the caller's promise.
    let (mut console, mut driver) = unsafe { start(Model::Latched) };
    let code = driver.set_speed(held, order, CALL);
    let dump = driver.dump(held, 0);
    console.set_speed(&dump, code);
    let mut last_dump = CALL.wrapping_add(FIRST_DUMP).wrapping_sub(EVERY);
    let mut stopped = false;
    loop {
        let now = console.millis();
        if now.wrapping_sub(last_dump) < EVERY {
            continue;
        }
        last_dump = now;
        if held.with(|pace| pace.is_moving()) {
            // All numbers are read first: sending them takes longer than a step.
            let phase = held.phase();
            let dump = driver.dump(held, phase);
            console.dump(&dump);
        } else if !stopped {
            console.line("Motor halted");
            let code = driver.set_speed(held, &SetSpeed::STOP, now);
            let dump = driver.dump(held, 0);
            console.set_speed(&dump, code);
            stopped = true;
        }
    }
}

/// Makes a program in which the shield's motor carries out one order and prints the log.
#[macro_export]
macro_rules! logged_case {
    ($order:expr) => {
        $crate::timed_motor!(
            /// The shield's motor on timer 1.
            mod motor, Timer1, PortB, TIMER1_COMPA
        );

        const ORDER: stepwright_timed::SetSpeed = $order;

        #[avr_device::entry]
        fn main() -> ! {
            use $crate::timed::{example, shield};
            shield::pins();
            // SAFETY: called once, with interrupts off.
            let mut held = unsafe { motor::take(shield::lines(shield::DIRECTION), 1) };
            // SAFETY: likewise, and the motor is made.
            unsafe { example::logged(&mut held, &ORDER) }
        }
    };
}
