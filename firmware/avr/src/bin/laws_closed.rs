//! What a step of a law costs: the trapezoid in closed form, the published listing, the law in the interrupt. See `stepwright_avr::law`.
#![no_std]
#![no_main]

use stepwright::Speed;
use stepwright::direct::Ramp;
use stepwright::profile::Trapezoid;
use stepwright::profile::austin::Fixed;
use stepwright_avr::law::{LISTED, STEPS, Trial};

#[avr_device::entry]
fn main() -> ! {
    let _ = laws();
    loop {}
}

/// `None` if one can't be laid out.
fn laws() -> Option<()> {
    // SAFETY: called once.
    let mut trial = unsafe { Trial::begin() }?;
    let (rate, top, accel) = (trial.rate, trial.top, trial.accel);
    trial.run(Trapezoid::new(rate, Speed::ZERO, top, accel).delays(STEPS).ok()?);
    trial.run(Fixed::new(STEPS, LISTED.0, LISTED.1));
    trial.run(Ramp::new(STEPS, LISTED.0, LISTED.1));
    Some(())
}
