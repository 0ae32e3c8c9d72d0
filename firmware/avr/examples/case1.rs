//! The Arduino driver, case 1: decelerating rotation, clocked by the step interrupt, until 8900 steps
//! are made.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright_timed::{Control, SetSpeed};

stepwright_avr::logged_case!(SetSpeed {
    control: Control::SPEED_VARIABLE
        .and(Control::IRQ_TIMING)
        .and(Control::VARIABLE_PWR)
        .and(Control::SLOWER)
        .and(Control::DRV_EN),
    top: 15_000,
    limit: 8_900,
    modification: 64,
    update_ms: 1_000,
    mod_counts: 19,
});
