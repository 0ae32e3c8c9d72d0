//! The Arduino driver, case 2: accelerating rotation, clocked by the step interrupt, without an
//! end.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright_timed::{Control, SetSpeed};

stepwright_avr::logged_case!(SetSpeed {
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
});
