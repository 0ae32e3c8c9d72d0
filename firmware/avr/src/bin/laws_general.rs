//! What a step of a law costs: the general form, c/2n, a ramp that changes (up, down). See `stepwright_avr::law`.
#![no_std]
#![no_main]

use stepwright::profile::austin::{Austin, Divisor, Ramp, Slope};
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
    let law = Austin::new(rate, top, accel);
    trial.run(law.delays(STEPS).ok()?);
    trial.run(law.with_divisor(Divisor::TwoN).delays(STEPS).ok()?);
    let mut ramp = Ramp::new(rate, accel, Default::default()).ok()?;
    trial.run(ramp.by_ref().take(STEPS as usize / 2));
    ramp.set(Slope::Down(accel));
    trial.run(ramp);
    Some(())
}
