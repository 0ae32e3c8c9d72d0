//! What a step of a law costs: the power term of 2 and of 4. See `stepwright_avr::law`.
#![no_std]
#![no_main]

use stepwright::profile::austin::PowerTerm;
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
    trial.run(PowerTerm::new(rate, top, accel, 2).delays(STEPS).ok()?);
    trial.run(PowerTerm::new(rate, top, accel, 4).delays(STEPS).ok()?);
    Some(())
}
