//! What a step of a law costs: the linear factor, piecewise. See `stepwright_avr::law`.
#![no_std]
#![no_main]

use stepwright::profile::austin::{LinearFactor, Piecewise};
use stepwright_avr::law::{STEPS, Trial};

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
    trial.run(LinearFactor::new(rate, top, accel).delays(STEPS).ok()?);
    trial.run(Piecewise::new(rate, top, accel).delays(STEPS).ok()?);
    Some(())
}
