//! The piecewise ramp moves a motor. See `stepwright_avr::law`.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::{Accel, Speed};
use stepwright_austin::Piecewise;
use stepwright_avr::law::STEPS;

stepwright_avr::measured_laws!(trial => {
    let law = Piecewise::new(trial.rate, trial.top, trial.accel);
    trial.measure(law.delays(STEPS).ok()?);
    let (top, accel) = (Speed::from_steps(500).ok()?, Accel::from_steps(2_000).ok()?);
    trial.play(Piecewise::new(trial.rate, top, accel).delays(STEPS).ok()?);
});
