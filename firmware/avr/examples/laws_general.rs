//! Austin's general form, c/2n, and a ramp whose acceleration changes on the way (Eq 18) move a
//! motor. See `stepwright_avr::law`.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

use stepwright::Accel;
use stepwright_austin::{Austin, Divisor, Ramp, Slope};
use stepwright_avr::law::STEPS;

stepwright_avr::measured_laws!(trial => {
    let law = Austin::new(trial.rate, trial.top, trial.accel);
    trial.measure(law.delays(STEPS).ok()?);
    trial.measure(law.with_divisor(Divisor::TwoN).delays(STEPS).ok()?);
    let mut ramp = Ramp::new(trial.rate, trial.accel, Default::default()).ok()?;
    trial.measure(ramp.by_ref().take(STEPS as usize / 2));
    ramp.set(Slope::Down(trial.accel));
    trial.measure(ramp);

    trial.play(law.delays(STEPS).ok()?);
    trial.play(law.with_divisor(Divisor::TwoN).delays(STEPS).ok()?);
    // Up at 200, then 500, and down at 400 steps/s².
    let accel = |steps| Accel::from_steps(steps).ok();
    let (faster, down) = (Slope::Up(accel(500)?), Slope::Down(accel(400)?));
    let mut ramp = Ramp::new(trial.rate, accel(200)?, Default::default()).ok()?;
    let mut step = 0;
    trial.play(core::iter::from_fn(|| {
        step += 1;
        match step {
            101 => ramp.set(faster),
            301 => ramp.set(down),
            _ => {}
        }
        ramp.next()
    }));
});
