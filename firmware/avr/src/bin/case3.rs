//! Document 000, case 3: the updates are checked by the main loop, every 50 ms, and a
//! callback tells that the motor has reached its end.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use motor::Held;
use stepwright::drive::sequence::SHIELD;
use stepwright::timed::{Call, Control, Driver, Model, SetSpeed};
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
        .and(Control::VARIABLE_PWR)
        .and(Control::FASTER)
        .and(Control::DRV_EN),
    top: 4_800_000,
    limit: 10_000,
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

    console.wait_until(CALL);
    driver.set_speed(&mut held, &ORDER, CALL);
    console.line("From now you see increasing counter from main loop");
    let (mut counts, mut previous, mut update) = (0u32, CALL, CALL);
    loop {
        let now = console.millis();
        if now.wrapping_sub(update) >= 50 {
            driver.update_check(&mut held, now, |call| {
                if call == Call::Reached {
                    console.line("Motor position reached / rotation stopped");
                }
            });
            update = now;
        }
        counts = counts.wrapping_add(1);
        if now.wrapping_sub(previous) > 1_000 {
            previous = now;
            console.number(counts);
            console.line("");
        }
    }
}

/// Milliseconds at the call.
const CALL: u32 = 1_009;
