//! The power term of 2 and of 4 moves a motor. See `stepwright_avr::law`.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::{Accel, Speed};
use stepwright_austin::PowerTerm;
use stepwright_avr::law::STEPS;

stepwright_avr::measured_laws!(trial => {
    for p in [2, 4] {
        let law = PowerTerm::new(trial.rate, trial.top, trial.accel, p);
        trial.measure(law.delays(STEPS).ok()?);
    }
    let (top, accel) = (Speed::from_steps(150).ok()?, Accel::from_steps(500).ok()?);
    for p in [2, 4] {
        let law = PowerTerm::new(trial.rate, top, accel, p);
        trial.play(law.delays(300).ok()?);
    }
});
