//! What a step of a law costs: the general form, c/2n, a ramp that changes (up, down). See
//! `stepwright_avr::law`.
#![no_std]
#![no_main]

use stepwright_austin::{Austin, Divisor, Ramp, Slope};
use stepwright_avr::law::STEPS;

stepwright_avr::measured_laws!(trial => {
    let law = Austin::new(trial.rate, trial.top, trial.accel);
    trial.run(law.delays(STEPS).ok()?);
    trial.run(law.with_divisor(Divisor::TwoN).delays(STEPS).ok()?);
    let mut ramp = Ramp::new(trial.rate, trial.accel, Default::default()).ok()?;
    trial.run(ramp.by_ref().take(STEPS as usize / 2));
    ramp.set(Slope::Down(trial.accel));
    trial.run(ramp);
});
