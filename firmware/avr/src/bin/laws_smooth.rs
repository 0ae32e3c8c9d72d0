//! What a step of a law costs: the linear factor, piecewise. See `stepwright_avr::law`.
#![no_std]
#![no_main]

use stepwright_austin::{LinearFactor, Piecewise};
use stepwright_avr::law::STEPS;

stepwright_avr::measured_laws!(trial => {
    let factor = LinearFactor::new(trial.rate, trial.top, trial.accel);
    trial.run(factor.delays(STEPS).ok()?);
    let pieces = Piecewise::new(trial.rate, trial.top, trial.accel);
    trial.run(pieces.delays(STEPS).ok()?);
});
