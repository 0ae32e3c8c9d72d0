//! The Arduino driver, case 3: the main loop checks for updates every 50 ms, and a callback reports
//! that the motor has reached its end.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright_avr::timed::example::{self, CALL};
use stepwright_avr::timed::shield;
use stepwright_timed::{Call, Control, Model, SetSpeed};

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
    shield::pins();
    // SAFETY: called once, with interrupts off.
    let mut held = unsafe { motor::take(shield::lines(shield::DIRECTION), 1) };
    // SAFETY: likewise, and the motor is made.
    let (mut console, mut driver) = unsafe { example::start(Model::Latched) };
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
