//! The cost of a step of the trapezoid in closed form. It moves no motor: on a chip the planner
//! does. See `stepwright_avr::law`.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::Speed;
use stepwright::profile::Trapezoid;
use stepwright_avr::law::STEPS;

stepwright_avr::measured_laws!(trial => {
    let law = Trapezoid::new(trial.rate, Speed::ZERO, trial.top, trial.accel);
    trial.measure(law.delays(STEPS).ok()?);
});
