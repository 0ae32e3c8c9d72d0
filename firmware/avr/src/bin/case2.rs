//! Document 000, case 2: faster while spinning, clocked by the step interrupt, without an
//! end.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use motor::Held;
use stepwright::drive::sequence::SHIELD;
use stepwright::timed::{Control, Driver, Model, SetSpeed};
use stepwright::timer::fit::Hardware;
use stepwright_avr::chip;
use stepwright_avr::console::Console;
use stepwright_avr::timed::{self, Timer1};

stepwright_avr::timed_motor!(
    /// The shield's motor on timer 1.
    mod motor, Timer1, PortB, TIMER1_COMPA
);

const ORDER: SetSpeed = SetSpeed {
    control: Control::SPEED_VARIABLE
        .and(Control::IRQ_TIMING)
        .and(Control::VARIABLE_PWR)
        .and(Control::FASTER)
        .and(Control::DRV_EN),
    top: 4_800_000,
    limit: 0,
    modification: 2_385_000,
    update_ms: 1_000,
    mod_counts: 11,
};

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: the only time that anybody takes them, and interrupts are off.
    let chip = unsafe { chip::Peripherals::steal() };
    timed::pins();
    let lines = SHIELD.on_bits(&timed::DIRECTION);
    // SAFETY: called once, with interrupts off.
    let mut held = unsafe { Held::new(lines, timed::mask_of(timed::DIRECTION), 1) };
    Timer1::start(chip.TC1);
    let mut console = Console::start(chip.USART0, chip.TC2);
    let clock = timed::io_clock_now();
    let mut driver = Driver::new(Hardware::avr16(clock), Model::Latched);
    // SAFETY: all that an interrupt touches has been made.
    unsafe { avr_device::interrupt::enable() };
    console.line("IRQ Timer 1 Enabled");
    console.text("Ioclk ");
    console.number(clock);
    console.line(" Hz");

    // As in the log: `millis()` at the call, and the first dump of the main loop so much
    // later.
    console.wait_until(CALL);
    let code = driver.set_speed(&mut held, &ORDER, CALL);
    let dump = driver.dump(&mut held, 0);
    console.set_speed(&dump, code);
    let mut last_dump = CALL.wrapping_add(FIRST_DUMP).wrapping_sub(EVERY);
    let mut stopped = false;
    loop {
        let now = console.millis();
        if now.wrapping_sub(last_dump) >= EVERY {
            last_dump = now;
            if held.is_moving() {
                // All numbers first: sending them takes longer than a step.
                let phase = held.phase();
                let dump = driver.dump(&mut held, phase);
                console.dump(&dump);
            } else if !stopped {
                console.line("Motor halted");
                let code = driver.set_speed(&mut held, &SetSpeed::STOP, now);
                let dump = driver.dump(&mut held, 0);
                console.set_speed(&dump, code);
                stopped = true;
            }
        }
    }
}

/// Milliseconds at the call, from there to the first dump, and between dumps.
const CALL: u32 = 1_009;
const FIRST_DUMP: u32 = 167;
const EVERY: u32 = 1_001;
