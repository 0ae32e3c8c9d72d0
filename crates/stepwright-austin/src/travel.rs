//! Up, level, down: the phases of a travel, by counting steps.
//!
//! A step up is made while the remaining steps are enough for the way down after it. The rest is
//! travelled at the speed reached; for a short even travel that is the delay which the published
//! listing repeats.

use super::count::Law;
use crate::share::share;
use stepwright::fixed::Q32;
use stepwright::profile::Phase;

/// A ramp that can be followed up and down.
pub trait Slopes {
    /// Makes one step up if the top speed is not reached and the way down from there takes no more
    /// than `left` steps; otherwise does nothing and returns `false`.
    fn faster(&mut self, left: u32) -> bool;

    /// Makes one step down, the j-th from the end.
    fn slower(&mut self, j: u32);

    /// The steps down to rest from here, before the way down begins.
    fn braking(&self) -> u32;

    /// The delay.
    fn count(&self) -> Q32;
}

/// A travel over a ramp: up, level, down.
#[derive(Clone, Debug)]
pub struct Travel<S> {
    slopes: S,
    phase: Phase,
    /// The steps of the way down, once they are known.
    brake: u32,
}

impl<S: Slopes> Travel<S> {
    pub(crate) fn new(slopes: S) -> Travel<S> {
        Travel { slopes, phase: Phase::Up, brake: 0 }
    }

    /// The ramps, on the way up.
    pub(crate) fn rising(&mut self) -> Option<&mut S> {
        (self.phase == Phase::Up).then_some(&mut self.slopes)
    }
}

impl<S: Slopes> Law for Travel<S> {
    #[inline]
    fn advance(&mut self, left: u32) -> Phase {
        if self.phase == Phase::Up {
            if self.slopes.faster(left) {
                return Phase::Up;
            }
            self.stop();
        }
        if self.phase == Phase::Cruise {
            if left >= self.brake {
                return Phase::Cruise;
            }
            self.phase = Phase::Down;
        }
        self.slopes.slower(self.brake);
        self.brake = self.brake.saturating_sub(1);
        Phase::Down
    }

    fn count(&self) -> u64 {
        self.slopes.count()
    }

    fn stop(&mut self) -> u32 {
        if self.phase == Phase::Up {
            self.phase = Phase::Cruise;
            self.brake = self.slopes.braking();
        }
        self.brake
    }
}

/// A curve that is followed step by step from rest, and back.
pub trait Curve: Clone + PartialEq {
    /// Makes one step up.
    fn up(&mut self);

    /// Makes one step down: returns the fraction (n, d) of a delay to add to it.
    fn down(&mut self) -> (u64, u64);

    /// The number of steps from rest.
    fn steps(&self) -> u32;

    /// The delay.
    fn count(&self) -> Q32;

    /// Whether no further step, however many follow, is as fast as this delay.
    fn stays_above(&self, _count: Q32) -> bool {
        false
    }
}

/// Two curves without a closed form: the way up, and the way down, which follows it like a shadow
/// and is always at its first step that is as fast. So the way down from here is known, at the cost
/// of two steps per step.
#[derive(Clone, Debug)]
pub struct Shadowed<C> {
    rise: C,
    fall: C,
    count: Q32,
    /// A delay this short is the top speed.
    enough: Q32,
}

impl<C: Curve> Shadowed<C> {
    /// `fall` begins at rest, too.
    pub(crate) fn new(rise: C, fall: C, enough: Q32) -> Shadowed<C> {
        let count = rise.count();
        let mut both = Shadowed { rise, fall, count, enough };
        // The first delay may be shorter than that of `fall`.
        both.follow(&both.rise.clone(), u32::MAX);
        both
    }

    /// Moves the shadow up to the delay of `rise`, which is the next step of the way up. Returns
    /// `false`, and does not move, beyond `left` steps.
    fn follow(&mut self, rise: &C, left: u32) -> bool {
        let count = rise.count().max(self.enough);
        let mut fall = self.fall.clone();
        while fall.count() > count {
            if fall.steps() >= left || fall.stays_above(count) {
                return false;
            }
            // If the shadow is where the rise was, its next step leads to where the rise is now:
            // equal ramps take one step per step. A small chip has no room for the shortcut.
            if cfg!(any(target_pointer_width = "64", target_family = "wasm")) && fall == self.rise {
                fall = rise.clone();
            } else {
                fall.up();
            }
        }
        self.fall = fall;
        self.fall.steps() <= left
    }
}

impl<C: Curve> Slopes for Shadowed<C> {
    fn faster(&mut self, left: u32) -> bool {
        if self.count <= self.enough {
            return false;
        }
        let mut rise = self.rise.clone();
        rise.up();
        if !self.follow(&rise, left) {
            return false;
        }
        self.count = rise.count();
        self.rise = rise;
        true
    }

    fn slower(&mut self, _j: u32) {
        let (n, d) = self.fall.down();
        self.count = self.count.saturating_add(share(self.count, n, d));
    }

    fn braking(&self) -> u32 {
        self.fall.steps()
    }

    fn count(&self) -> Q32 {
        self.count
    }
}
