//! A ramp with bent ends: the S-curve, on a small chip.
//!
//! Between two speeds the acceleration comes and goes at the jerk J. With the
//! time t and the steps x counted from the low end, a bend of
//! b = min(A/J, √(Δv/J)), and of t the part β = min(t, b) bent, u = t − β not:
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
//! When pulse x comes is found the other way round, from a guess:
//! t ← t − (x(t) − x) / v(t), each step of which doubles the digits that are right.
//!
//! **Error.** Time and steps are computed from an end of the ramp: 2⁻²⁹ of the
//! ramp's time; and where it eases down to a level, 2⁻²⁸ of its steps, which are
//! gone at the low speed. **Cost** on an ATmega328P: see `planner`.

use crate::num::Num;

/// One ramp, up or down. Times are in 1000 s, as speeds are in 0.001 steps/s.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Curve {
    /// J/2; 0: there is no limit, and this is not a curve.
    half_jerk: Num,
    /// Speeds at its ends.
    low: Num,
    high: Num,
    /// Time of a bend, and of all.
    bend: Num,
    whole: Num,
    /// Steps of all.
    length: Num,
}

/// Speed and place on a ramp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    pub(super) v: Num,
    pub(super) x: Num,
}

impl Curve {
    /// No ramp, and no limit of jerk.
    pub(super) const STRAIGHT: Curve = Curve {
        half_jerk: Num::UNSET,
        low: Num::UNSET,
        high: Num::UNSET,
        bend: Num::UNSET,
        whole: Num::UNSET,
        length: Num::UNSET,
    };

    /// Has a jerk, in 0.001 steps/s³, or none (0).
    pub(super) fn set_jerk(&mut self, jerk: u64) {
        // J/2 in 0.001 steps/s per (1000 s)²: 500,000 J.
        self.half_jerk = Num::from_wide(jerk).times(&Num::small(62_500)).scaled(3);
    }

    /// Has a jerk so large that the shortest bend lasts less than 10⁻¹⁵ s.
    pub(super) fn set_no_bends(&mut self) {
        // The largest acceleration is 2⁵⁰ of these units or less.
        self.half_jerk = Num::power(110);
    }

    /// Whether the jerk is limited.
    pub(super) fn is_bent(&self) -> bool {
        !self.half_jerk.is_zero()
    }

    /// Whether the first step from rest takes less than 1000 s · 2^e.
    pub(super) fn starts_within(&self, e: i8) -> bool {
        // x = J/6·t³.
        Num::small(3).over(&self.half_jerk).is_below(e.wrapping_mul(3))
    }

    /// Lays the ramp between two speeds, at this slope (2A).
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn lay(&mut self, low: &Num, high: &Num, slope: &Num) {
        let gain = high.minus(low);
        (self.low, self.high) = (*low, *high);
        self.bend = slope.over(&self.half_jerk).scaled(-2);
        // What both bends gain: A²/J.
        if gain.at_least(&slope.times(&self.bend).scaled(-1)) {
            self.whole = gain.over(slope).scaled(1).plus(&self.bend);
        } else {
            self.bend = gain.over(&self.half_jerk).scaled(-1).root();
            self.whole = self.bend.scaled(1);
        }
        self.measure();
    }

    /// The length follows from the rest.
    fn measure(&mut self) {
        self.length = self.low.plus(&self.high).times(&self.whole).scaled(-1);
    }

    /// Steps of the ramp.
    pub(super) fn length(&self) -> &Num {
        &self.length
    }

    /// Time of the ramp.
    pub(super) fn whole(&self) -> &Num {
        &self.whole
    }

    /// Steps more for each 0.001 steps/s that its high end is higher.
    pub(super) fn growth(&self) -> Num {
        let peak = self.half_jerk.times(&self.bend).scaled(2);
        self.whole.plus(&self.low.plus(&self.high).over(&peak).scaled(1)).scaled(-1)
    }

    /// Time from there to the high end.
    pub(super) fn tail(&self, t: &Num) -> Num {
        self.whole.minus(t)
    }

    /// Whether the acceleration is constant at that time.
    pub(super) fn is_straight(&self, t: &Num) -> bool {
        t.at_least(&self.bend) && self.tail(t).at_least(&self.bend)
    }

    /// J/2.
    pub(super) fn half_jerk(&self) -> &Num {
        &self.half_jerk
    }

    /// Speed at the high end.
    pub(super) fn high(&self) -> &Num {
        &self.high
    }

    /// Speed at the low end.
    pub(super) fn low(&self) -> &Num {
        &self.low
    }

    /// Speed and place at a time from the low end.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn at(&self, t: &Num) -> Moment {
        let tail = self.whole.minus(t);
        let ending = self.bend.at_least(&tail);
        let t = if ending { &tail } else { t };
        let bent = if t.at_least(&self.bend) { &self.bend } else { t };
        let straight = t.minus(bent);
        let e = self.half_jerk.times(bent);
        let v = e.times(&t.plus(&straight));
        let x = bent.times(bent).times(&THIRD).plus(&straight.times(t)).times(&e);
        if ending {
            let back = self.high.times(t).minus(&x);
            Moment { v: self.high.minus(&v), x: self.length.minus(&back) }
        } else {
            Moment { v: self.low.plus(&v), x: self.low.times(t).plus(&x) }
        }
    }

    /// A time near which x is, when the last pulse, at t, was this many steps
    /// before (on the way up) or after it, at v.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn guess(&self, t: &Num, v: &Num, steps: &Num, x: &Num, up: bool) -> Num {
        let t = if v.is_zero() {
            // From rest: x = J/6·t³, to a power of two.
            x.over(&self.half_jerk).scaled(1).near_cube_root()
        } else {
            // At the acceleration here: n/v, and from that the mean speed.
            let tail = self.tail(t);
            let mut bent = if t.at_least(&tail) { &tail } else { t };
            if bent.at_least(&self.bend) {
                bent = &self.bend;
            }
            let change = self.half_jerk.roughly(bent).roughly(&steps.over(v));
            let mean = if up { v.plus(&change) } else { v.minus(&change) };
            let by = steps.over(if mean.at_least(&v.scaled(-2)) { &mean } else { v });
            if up { t.plus(&by) } else { t.minus(&by) }
        };
        if t.at_least(&self.whole) { self.whole } else { t }
    }

    /// Brings t nearer to when x is; whether it is there.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn correct(&self, t: &mut Num, here: &Moment, x: &Num) -> bool {
        let behind = x.at_least(&here.x);
        let off = if behind { x.minus(&here.x) } else { here.x.minus(x) }.over(&here.v);
        *t = if behind { t.plus(&off) } else { t.minus(&off) };
        if t.at_least(&self.whole) {
            *t = self.whole;
        }
        // What is left is less than off²/t, and 2⁻³⁰ of t.
        t.at_least(&off.scaled(15))
    }

    /// Ends the ramp up as soon as the jerk allows, t after its beginning.
    pub(super) fn level_out(&mut self, t: &Num) {
        if self.bend.at_least(&self.tail(t)) {
            return;
        }
        self.high = self.at(t).v;
        self.shorten(t);
        self.high = self.high.plus(&self.lost());
        self.measure();
    }

    /// Ends the ramp down as soon as the jerk allows, where t is left of it; how much
    /// was left is t's place then.
    pub(super) fn level_out_below(&mut self, t: &mut Num) {
        if self.bend.at_least(t) {
            return;
        }
        let v = self.at(t).v;
        let done = self.tail(t);
        self.shorten(&done);
        *t = self.bend;
        self.low = v.minus(&self.lost());
        self.measure();
    }

    /// Only so much of the ramp is done, and a bend that ends it.
    fn shorten(&mut self, done: &Num) {
        if self.bend.at_least(done) {
            self.bend = *done;
        }
        self.whole = done.plus(&self.bend);
    }

    /// What a bend changes the speed by.
    fn lost(&self) -> Num {
        self.half_jerk.times(&self.bend).times(&self.bend)
    }
}

/// 1/3.
const THIRD: Num = Num::and_inverse(3).1;
