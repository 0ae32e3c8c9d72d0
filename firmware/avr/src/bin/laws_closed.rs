//! What a step of a law costs: the trapezoid in closed form, the published listing, the
//! same with its remainder carried. See `stepwright_avr::law`.
#![no_std]
#![no_main]

use stepwright::Speed;
use stepwright::profile::Trapezoid;
use stepwright_austin::{Carried, Fixed};
use stepwright_avr::law::{LISTED, STEPS};

stepwright_avr::measured_laws!(trial => {
    let law = Trapezoid::new(trial.rate, Speed::ZERO, trial.top, trial.accel);
    trial.run(law.delays(STEPS).ok()?);
    trial.run(Fixed::new(STEPS, LISTED.0, LISTED.1));
    trial.run(Carried::new(STEPS, LISTED.0, LISTED.1));
});
