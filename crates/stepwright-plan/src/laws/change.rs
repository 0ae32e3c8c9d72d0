//! A ramp whose acceleration changes on the way (Eq 18), planned and ordered.
//!
//! ```text
//!   (n₁ + ½)·a₁ = (n₂ + ½)·a₂
//! ```
//!
//! A change after n steps holds from the delay after that step on, as on a board.

use stepwright::{Accel, Ticks};
use stepwright_austin::general::Ramps as CoreRamps;
use stepwright_austin::{Pulses, Travel};
use stepwright_units::Rounded;

use super::formula::{At, Ramps, Turns};
use crate::equations::next;
use crate::law::PlanValue;

/// A change as held: after this many steps, this acceleration.
pub type RampChange = (u32, Rounded<Accel>);

/// The changes as lines of the summary.
pub(crate) fn values(changes: &[RampChange]) -> impl Iterator<Item = PlanValue> {
    changes.iter().map(|(steps, accel)| {
        let shown = format!("{accel} after {steps} steps");
        PlanValue { shown, ..PlanValue::accel("change", accel) }
    })
}

/// The core's delays, with the changes ordered during the travel.
#[derive(Clone)]
pub(crate) struct Changed {
    delays: Pulses<Travel<CoreRamps>>,
    /// The changes to come, the next one last.
    changes: Vec<(u32, Accel)>,
    made: u32,
}

impl Changed {
    /// These delays with these changes, in the order of their steps.
    pub fn new(delays: Pulses<Travel<CoreRamps>>, changes: &[RampChange]) -> Changed {
        let changes = changes.iter().rev().map(|(steps, accel)| (*steps, accel.value)).collect();
        Changed { delays, changes, made: 0 }
    }
}

impl Iterator for Changed {
    type Item = Ticks;

    fn next(&mut self) -> Option<Ticks> {
        while let Some((_, accel)) = self.changes.pop_if(|(after, _)| *after <= self.made) {
            // After the way up there is nothing to change.
            self.delays.set_accel(accel);
        }
        self.made += 1;
        self.delays.next()
    }
}

/// One step in the units in which the core holds n + ½ after a change.
const STEP: u128 = 1 << 28;

/// The formula: n + ½ of Eq 13, renumbered where the acceleration changes.
pub(crate) struct Changing {
    /// The first acceleration and the deceleration, in 0.001 steps/s².
    accel: u64,
    decel: u64,
    changes: Vec<(u32, u64)>,
}

impl Changing {
    /// From rest at `accel`, in steps/s².
    pub fn new(accel: f64, decel: f64, changes: &[RampChange]) -> Changing {
        let milli = |accel: f64| (accel * 1e3).round() as u64;
        let changes = changes.iter().map(|(steps, accel)| (*steps, accel.value.millisteps()));
        Changing { accel: milli(accel), decel: milli(decel), changes: changes.collect() }
    }

    /// The begin of the ramp: n = 0.
    fn begin(c: f64) -> At {
        At { c, ..At::default() }
    }

    /// n + ½ in the core's units.
    fn far(at: &At) -> u128 {
        ((at.n + 0.5) * STEP as f64).round() as u128
    }

    /// Applies the changes that hold from the next step up on. Returns the acceleration then.
    fn turn_over(&self, at: &mut At) -> u64 {
        let mut accel = match at.crossed {
            0 => self.accel,
            crossed => self.changes[crossed - 1].1,
        };
        // The step from i to i + 1 is the delay after pulse i + 2.
        while let Some((_, to)) =
            self.changes.get(at.crossed).filter(|(after, _)| *after <= at.i + 2)
        {
            let share = u128::from(accel) * Changing::far(at);
            let far = (2 * share + u128::from(*to)) / (2 * u128::from(*to));
            at.n = far as f64 / STEP as f64 - 0.5;
            at.crossed += 1;
            accel = *to;
        }
        accel
    }

    /// J after `more` steps up, rounded to the nearest.
    fn down(&self, at: &At, accel: u64, more: u128) -> u32 {
        let far = Changing::far(at) + more * STEP;
        let steps = far * u128::from(accel) / u128::from(self.decel) / STEP;
        u32::try_from(steps).unwrap_or(u32::MAX)
    }

    /// The turn of a travel of `pulses` pulses: it adds a step up while there is room for it and for the
    /// way down after it.
    pub fn turns(&self, pulses: u32, c: f64, least: f64) -> Turns {
        let mut at = Changing::begin(c);
        loop {
            let accel = self.turn_over(&mut at);
            let after = u64::from(at.i) + 2 + u64::from(self.down(&at, accel, 1));
            if at.c <= least || after > u64::from(pulses) {
                let down = self.down(&at, accel, 0);
                return Turns { up: at.i, down, complete: at.c <= least };
            }
            self.faster(&mut at);
        }
    }
}

impl Ramps for Changing {
    fn faster(&self, at: &mut At) {
        self.turn_over(at);
        at.i += 1;
        at.n += 1.0;
        at.c = next(at.c, at.n);
    }

    fn slower(&self, c: f64, j: u32) -> f64 {
        next(c, -f64::from(j))
    }
}
