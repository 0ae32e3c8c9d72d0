//! What a step of a law costs: the power term of 2 and of 4. See `stepwright_avr::law`.
#![no_std]
#![no_main]

use stepwright_austin::PowerTerm;
use stepwright_avr::law::STEPS;

stepwright_avr::measured_laws!(trial => {
    for p in [2, 4] {
        let law = PowerTerm::new(trial.rate, trial.top, trial.accel, p);
        trial.run(law.delays(STEPS).ok()?);
    }
});
