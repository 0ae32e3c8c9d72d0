//! The linear factor moves a motor. See `stepwright_avr::law`.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::Speed;
use stepwright_austin::LinearFactor;
use stepwright_avr::law::STEPS;

stepwright_avr::measured_laws!(trial => {
    let law = LinearFactor::new(trial.rate, trial.top, trial.accel);
    trial.measure(law.delays(STEPS).ok()?);
    let top = Speed::from_steps(1_200).ok()?;
    trial.play(LinearFactor::new(trial.rate, top, trial.accel).delays(STEPS).ok()?);
});
