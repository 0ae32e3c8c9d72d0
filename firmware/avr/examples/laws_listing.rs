//! The published listing moves a motor as the article's demo does: 1,000 steps there, and
//! back with the division's remainder carried. See `stepwright_avr::law`.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright_austin::{Carried, Fixed};
use stepwright_avr::law::{DEMO, LISTED, STEPS};

stepwright_avr::measured_laws!(trial => {
    trial.measure(Fixed::new(STEPS, LISTED.0, LISTED.1));
    trial.measure(Carried::new(STEPS, LISTED.0, LISTED.1));
    trial.play(Fixed::new(STEPS, DEMO.0, DEMO.1));
    trial.play(Carried::new(STEPS, DEMO.0, DEMO.1));
    // As fast as the law can be computed.
    trial.play(Fixed::new(STEPS, LISTED.0, LISTED.1));
    trial.play(Carried::new(STEPS, LISTED.0, LISTED.1));
});
