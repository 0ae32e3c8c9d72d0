//! Two motor shields on two timers of a Mega at once, which the Arduino driver does not support:
//! the lower one on timer 1 with D12 and D13, the upper one on timer 3 with D9 and D8. On both the
//! brake lines are cut (section 3).
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright_avr::chip;
use stepwright_avr::console::Console;
use stepwright_avr::timed::{io_clock_now, shield};
use stepwright_timed::fit::Hardware;
use stepwright_timed::{Control, Driver, Model, SetSpeed};

stepwright_avr::timed_motor!(
    /// The lower shield's motor.
    mod lower, Timer1, PortB, TIMER1_COMPA
);
stepwright_avr::timed_motor!(
    /// The upper shield's motor.
    mod upper, Timer3, PortH, TIMER3_COMPA
);

/// Slower every 200 ms.
const LOWER: SetSpeed = SetSpeed {
    control: Control::DRV_EN
        .and(Control::SPEED_VARIABLE)
        .and(Control::VARIABLE_PWR)
        .and(Control::IRQ_TIMING),
    top: 15_000,
    limit: 3_000,
    modification: 64,
    update_ms: 200,
    mod_counts: 10,
};
/// Faster, and in the other direction.
const UPPER: SetSpeed = SetSpeed {
    control: Control::DRV_EN
        .and(Control::SPEED_VARIABLE)
        .and(Control::IRQ_TIMING)
        .and(Control::FASTER)
        .and(Control::DIRECTION),
    top: 80_000,
    limit: 2_000,
    modification: 3_000,
    update_ms: 100,
    mod_counts: 24,
};

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: they are taken only here, and interrupts are off.
    let chip = unsafe { chip::Peripherals::steal() };
    shield::pins();
    // SAFETY: called once each, with interrupts off.
    let (mut lower, mut upper) = unsafe {
        (
            lower::take(shield::lines(shield::DIRECTION), 1),
            upper::take(shield::lines(shield::DIRECTION_2), 2),
        )
    };
    let mut console = Console::start(chip.USART0, chip.TC0);
    let hardware = Hardware::avr16(io_clock_now());
    let mut first = Driver::new(hardware, Model::Ideal);
    let mut second = Driver::new(hardware, Model::Ideal);
    // SAFETY: everything that an interrupt uses is set up.
    unsafe { avr_device::interrupt::enable() };
    first.set_speed(&mut lower, &LOWER, 0);
    second.set_speed(&mut upper, &UPPER, 0);
    let (mut moving, mut at) = ((true, true), 0);
    loop {
        if (console.millis().wrapping_sub(at) as i32) < 0 {
            continue;
        }
        at = at.wrapping_add(10);
        let now = (lower.is_moving(), upper.is_moving());
        if moving.0 && !now.0 {
            first.set_speed(&mut lower, &SetSpeed::STOP, at);
            console.line("lower shield: position reached");
        }
        if moving.1 && !now.1 {
            second.set_speed(&mut upper, &SetSpeed::STOP, at);
            console.line("upper shield: position reached");
        }
        moving = now;
    }
}
