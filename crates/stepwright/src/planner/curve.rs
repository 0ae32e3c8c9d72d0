//! A ramp with bent ends: the S-curve, on a small chip.
//!
//! Between two speeds the acceleration grows and falls at the jerk J. The time t and the steps x
//! are counted from the low end. A bend takes b = min(A/J, √(Δv/J)); of the time t, β = min(t, b)
//! is bent and u = t − β is not:
//!
//! ```text
//!   v(t) = v_low  + J/2·β·(t + u)                       t ≤ whole − b
//!   x(t) = v_low·t + J/2·β·(β²/3 + u·t)
//!
//!   v ▲            ,--   the last bend is the first, turned round:
//!     │          /       v_high − J/2·τ², length − (v_high·τ − J/6·τ³)
//!     │        /         with τ = whole − t ≤ b
//!     │   __--`
//!     └──┬───────┬──┬► t   whole = Δv/A + b or 2b,  length = mean speed · whole
//!        b  whole−b  whole
//! ```
//!
//! The time of pulse x is found iteratively, from a guess: t ← t − (x(t) − x) / v(t). Each
//! iteration doubles the number of correct digits.
//!
//! **Error.** Time and steps are computed from an end of the ramp: 2⁻²⁹ of the ramp's time; where
//! it eases down to a level, 2⁻²⁸ of its steps, which are made at the low speed. **Cost** on an
//! ATmega328P: see `planner`.

use super::bent::Bent;
use crate::clamp;
use crate::num::{Hand, Num, hand, whole};

/// One ramp, up or down. Times are in 1000 s, because speeds are in 0.001 steps/s.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Curve {
    /// J/2.
    half_jerk: Bent,
    /// The speeds at the ends.
    low: Bent,
    high: Bent,
    /// The time of a bend, and of the whole ramp.
    bend: Bent,
    whole: Bent,
    /// The steps of the whole ramp.
    length: Num,
}

impl Curve {
    /// No ramp.
    pub(super) const NONE: Curve = Curve {
        half_jerk: Bent::UNSET,
        low: Bent::UNSET,
        high: Bent::UNSET,
        bend: Bent::UNSET,
        whole: Bent::UNSET,
        length: Num::UNSET,
    };

    /// Sets the jerk, in 0.001 steps/s³.
    pub(super) fn set_jerk(&mut self, jerk: u64) {
        // J/2 in 0.001 steps/s per (1000 s)²: 500,000 J.
        let half = &mut *self.half_jerk;
        half.set_wide(jerk);
        whole(500_000).times(half).to(half);
    }

    /// Whether the first step from rest takes less than 1000 s · 2^e.
    pub(super) fn starts_within(&self, e: i8) -> bool {
        // x = J/6·t³.
        whole(3).over(&self.half_jerk).below(e.wrapping_mul(3))
    }

    /// Sets up the ramp between two speeds, with this slope (2A). For a straight ramp only the
    /// length is computed.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn lay(&mut self, low: &Num, high: &Num, slope: &Num, straight: bool) {
        if straight {
            // Whole numbers are exact: no step of the ramp is divided needlessly.
            hand(low).square().to(&mut self.length);
            hand(high).square().minus(&self.length).over(slope).to(&mut self.length);
            return;
        }
        self.low.set(low);
        self.high.set(high);
        hand(high).minus(low).to(&mut self.length);
        hand(slope).over(&self.half_jerk).scaled(-2).to(&mut self.bend);
        // What both bends gain together: A²/J.
        hand(&self.bend).times(slope).scaled(-1).to(&mut self.whole);
        if hand(&self.length).at_least(&self.whole) {
            hand(&self.length).over(slope).scaled(1).plus(&self.bend).to(&mut self.whole);
        } else {
            let bend = hand(&self.length).over(&self.half_jerk).scaled(-1).root();
            bend.also(&mut self.bend).scaled(1).to(&mut self.whole);
        }
        self.measure();
    }

    /// Computes the length from the other values.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn measure(&mut self) {
        hand(&self.low).plus(&self.high).times(&self.whole).scaled(-1).to(&mut self.length);
    }

    /// The steps of the ramp, less the steps for 2⁻²⁸ of its highest speed², which is that of
    /// `high`: a ramp that was set up to fit still fits after rounding.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn scant(&self, high: &Num, slope: &Num) -> Hand {
        hand(high).square().scaled(-28).over(slope).off(&self.length)
    }

    /// Lengthens the ramp to whole steps.
    pub(super) fn round_up(&mut self, high: &Num, slope: &Num) {
        let (steps, part) = self.scant(high, slope).split();
        whole(clamp::sum(steps, (part != 0).into())).to(&mut self.length);
    }

    /// Steps of the ramp.
    pub(super) fn length(&self) -> &Num {
        &self.length
    }

    /// Time of the ramp.
    pub(super) fn whole(&self) -> &Num {
        &self.whole
    }

    /// The growth of the length in steps for each 0.001 steps/s that the high end is higher.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn growth(&self) -> Hand {
        let peak = hand(&self.half_jerk).times(&self.bend).scaled(2).number();
        hand(&self.low).plus(&self.high).over(&peak).scaled(1).plus(&self.whole).scaled(-1)
    }

    /// The time from `t` to the high end.
    pub(super) fn tail(&self, t: &Num) -> Hand {
        hand(&self.whole).minus(t)
    }

    /// Whether the acceleration is constant at time `t`.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn is_straight(&self, t: &Num) -> bool {
        t.at_least(&self.bend) && self.tail(t).at_least(&self.bend)
    }

    /// J/2.
    pub(super) fn half_jerk(&self) -> &Num {
        &self.half_jerk
    }

    /// The speed at the high end.
    pub(super) fn high(&self) -> &Num {
        &self.high
    }

    /// The speed at the low end.
    pub(super) fn low(&self) -> &Num {
        &self.low
    }

    /// Speed and place at a time from the low end.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn at(&self, t: &Num, v: &mut Num, x: &mut Num) {
        let mut near = self.tail(t).number();
        let ending = self.bend.at_least(&near);
        if !ending {
            near.set(t);
        }
        let bent = if near.at_least(&self.bend) { &*self.bend } else { &near };
        let straight = hand(&near).minus(bent).number();
        let e = hand(&self.half_jerk).times(bent).number();
        hand(&near).plus(&straight).times(&e).to(v);
        hand(bent).square().times(&THIRD).to(x);
        hand(&near).times(&straight).plus(x).times(&e).to(x);
        if ending {
            hand(&self.high).times(&near).minus(x).off(&self.length).to(x);
            hand(&self.high).minus(v).to(v);
        } else {
            hand(&self.low).times(&near).plus(x).to(x);
            hand(&self.low).plus(v).to(v);
        }
    }

    /// Guesses the time at place x; the last pulse, at t, was this many steps before it (on the way
    /// up) or after it, at v.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn guess(&self, t: &mut Num, v: &Num, steps: &Num, x: &Num, up: bool) {
        if v.is_zero() {
            // From rest: x = J/6·t³, to a power of two.
            *t = hand(x).over(&self.half_jerk).scaled(1).number().near_cube_root();
        } else {
            // The time is n/v; the mean acceleration is that at a third of the way ahead, and gives
            // the mean speed.
            let time = hand(steps).over(v).number();
            let mut near = hand(t).number();
            move_by(up, &mut near, &hand(&time).roughly(&THIRD).number());
            let mut by = self.tail(&near).number();
            if !near.at_least(&by) {
                by.set(&near);
            }
            if by.at_least(&self.bend) {
                by.set(&self.bend);
            }
            hand(&self.half_jerk).roughly(&by).roughly(&time).to(&mut by);
            let mut mean = hand(v).number();
            move_by(up, &mut mean, &by);
            hand(v).scaled(-2).to(&mut by);
            let mean = if mean.at_least(&by) { &mean } else { v };
            hand(steps).over(mean).to(&mut by);
            move_by(up, t, &by);
        }
        self.clamp(t);
    }

    /// Brings t nearer to the time at place x; `v` and `place` are those at t. Returns whether t is
    /// exact enough; the speed is still that of the previous t, at most some 2⁻¹⁵ of t away.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn correct(&self, t: &mut Num, v: &Num, place: &Num, x: &Num) -> bool {
        let behind = x.at_least(place);
        let (more, less) = if behind { (x, place) } else { (place, x) };
        let mut off = hand(more).minus(less).over(v).number();
        move_by(behind, t, &off);
        self.clamp(t);
        // The remaining error is less than off²/t, and 2⁻³⁰ of t.
        hand(&off).scaled(15).to(&mut off);
        t.at_least(&off)
    }

    /// Limits a time to the high end.
    fn clamp(&self, t: &mut Num) {
        if t.at_least(&self.whole) {
            t.set(&self.whole);
        }
    }

    /// Ends the ramp as soon as the jerk allows, at t from its low end; for a ramp down, sets t to
    /// the same place in the new ramp.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn level_out(&mut self, t: &mut Num, up: bool) {
        let mut done = hand(t).number();
        let mut rest = self.tail(t).number();
        if !up {
            core::mem::swap(&mut done, &mut rest);
        }
        if self.bend.at_least(&rest) {
            return;
        }
        // Only this much of the ramp is done, followed by a bend that ends it.
        let mut v = Num::UNSET;
        self.at(t, &mut v, &mut rest);
        if self.bend.at_least(&done) {
            self.bend.set(&done);
        }
        hand(&done).plus(&self.bend).to(&mut self.whole);
        // The change of speed in a bend.
        let lost = hand(&self.half_jerk).times(&self.bend).times(&self.bend).number();
        if up {
            hand(&lost).plus(&v).to(&mut self.high);
        } else {
            t.set(&self.bend);
            hand(&lost).off(&v).to(&mut self.low);
        }
        self.measure();
    }
}

/// Adds `by` to a number, or subtracts it.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub(super) fn move_by(up: bool, a: &mut Num, by: &Num) {
    let place = hand(a);
    if up { place.plus(by) } else { place.minus(by) }.to(a);
}

/// 1/3.
const THIRD: Num = Num::and_inverse(3).1;
