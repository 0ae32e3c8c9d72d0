//! The ramp in progress: straight, or with bent ends ([`Curve`](super::curve::Curve)).
//!
//! Both shapes are set up as curves. The end of a run of a bent ramp is found by its time, with
//! Newton's method; that of a straight ramp by speed² alone, which is linear in the steps:
//!
//! ```text
//!   v² = w_from + slope·x          x steps from the low end
//!   Δt = 2·N / (v₁ + v₂)           N steps from v₁ to v₂
//! ```
//!
//! An ease, which falls to a lower top speed, is whole steps long if it is straight, at d or a
//! little less. (Its length has 32 bits. If it were not whole, the rounding would be travelled at
//! the low speed and take long: 2⁻³¹ of 1000 steps is 3 ticks at 20 steps/s and 134 MHz.)

use super::{Clock, Layout, Planned, Planner, Stage, Work};
use crate::num::{Hand, Num, hand, part, whole};
use crate::units::Jerk;

impl Planner {
    /// Sets or removes the jerk limit of another travel.
    pub(super) fn limit_jerk(&mut self, jerk: Option<Jerk>) {
        // The last travel may have been stopped at once in the middle of a change.
        self.piece = Layout::Speeds;
        self.straight = jerk.is_none();
        if let Some(jerk) = jerk {
            self.curve.set_jerk(jerk.millisteps());
        }
    }

    /// Whether the first step from rest is no longer than an interval may be.
    pub(super) fn can_start(&self, clock: &Clock) -> bool {
        self.curve.starts_within(clock.second_eighth())
    }

    /// Whether a ramp up to this speed, whose square is w, would take less than 2²² steps if it
    /// consisted of bends only.
    pub(super) fn ends(&self, high: &Num, w: &Num) -> bool {
        // v·√(v/J) steps. Times in a ramp have an error of 2⁻²⁹ of its whole time: with this limit
        // 2⁻⁶ of an interval at its high end, otherwise possibly several intervals.
        hand(w).times(high).over(self.curve.half_jerk()).below(45)
    }

    /// The time to the high end, which is this part of a step ahead: from the last pulse handed
    /// out, at speed v or at time t.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn tail(&self, t: &Num, v: &Num, of_step: u32) -> Hand {
        if self.is_straight() {
            let both = hand(&self.v_top).plus(v).number();
            part(of_step).scaled(1).over(&both)
        } else {
            self.curve.tail(t)
        }
    }

    /// Whether the jerk is not limited.
    #[inline(always)]
    pub(crate) fn is_straight(&self) -> bool {
        !cfg!(feature = "jerk") || self.straight
    }

    /// Whether the rest must be set up again once the level is reached.
    #[inline(always)]
    pub(super) fn is_again(&self) -> bool {
        self.piece >= Layout::Rise && self.piece < Layout::Check
    }

    /// Whether the ramp in progress is the fall.
    #[inline(always)]
    pub(super) fn is_falling(&self) -> bool {
        self.piece == Layout::Nothing
    }

    /// Sets the speed at the end of a rise to that of its curve: pulses are found by their times,
    /// with an error of their speeds of some 2⁻¹⁵. A change may set up the rest from here.
    pub(super) fn reach(&mut self) {
        if !self.is_falling() && self.rise | self.rise_part == 0 {
            self.v.set(&self.v_top);
        }
    }

    /// Sets up the curve of a fall from the top speed.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn curve_of_fall(&mut self) {
        let straight = self.is_straight();
        self.curve.lay(&self.v_end, &self.v_top, &self.d2, straight);
    }

    /// Sets up the fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn lay_fall(&mut self) {
        if !self.is_straight() {
            self.curve_of_fall();
            self.at.set(self.curve.whole());
        }
        hand(&self.v_end).square().to(&mut self.w_from);
        self.slope.set(&self.d2);
        (self.piece, self.ease) = (Layout::Nothing, false);
    }

    /// The place on the ramp of the pulse this many steps ahead, from the low end.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn place_after(&self, steps: u16) -> Hand {
        let steps = u32::from(steps);
        if self.is_falling() {
            whole(self.fall.wrapping_sub(steps))
        } else if self.ease {
            let rest = part(self.rise_part).number();
            whole(self.rise.wrapping_sub(steps)).plus(&rest)
        } else {
            whole(self.risen.wrapping_add(steps))
        }
    }

    /// Finds, in several calls, the time of the pulse this many steps ahead, if the ramp is bent
    /// (`time`), and its speed (`pending`). Returns whether it is found.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn find(&self, work: &mut Work, steps: u16) -> bool {
        let begins = work.stage == Stage::Begin;
        let straight = self.is_straight();
        if straight && !begins {
            return true;
        }
        let x = self.place_after(steps);
        if straight {
            x.times(&self.slope).plus(&self.w_from).root().to(&mut work.pending);
            work.stage = Stage::Half;
            return false;
        }
        let x = x.number();
        let curve = &self.curve;
        if !begins {
            curve.at(&work.time, &mut work.pending, &mut work.mean);
            return curve.correct(&mut work.time, &work.pending, &work.mean, &x);
        }
        if x.is_zero() {
            whole(0).to(&mut work.time);
            work.pending.set(curve.low());
            return true;
        }
        // A fall begins in its corner.
        let begins = self.is_falling() && self.level != 0;
        let t = if begins { curve.whole() } else { &self.at };
        work.time.set(t);
        let up = !self.is_falling() && !self.ease;
        let steps = whole(steps.into()).number();
        curve.guess(&mut work.time, &self.v, &steps, &x, up);
        work.stage = Stage::Half;
        false
    }

    /// Does a piece of planning a ramp run: its end, its mean interval and δ, and the rest.
    #[inline(always)]
    pub(super) fn follow(&mut self, clock: &Clock, work: &mut Work, first: bool) {
        if !first && !self.is_falling() {
            self.lay_fall();
        } else if self.find(work, work.run.count) {
            let delta = self.measure(clock, work);
            self.shape(clock, work, first, delta);
        }
    }

    /// The mean interval of a ramp run, and its δ divided by its steps.
    #[inline(always)]
    fn measure(&self, clock: &Clock, work: &mut Work) -> Hand {
        if self.is_straight() {
            // δ/N = 2·slope/(v₁ + v₂)². A few bits suffice: the run's end is exact.
            let mean = hand(&work.pending).plus(&self.v).under(&clock.twice).also(&mut work.mean);
            let by = mean.roughly(&clock.inverse).also(&mut work.delta);
            by.roughly(&work.delta).roughly(&self.slope)
        } else {
            let at = &self.at;
            let up = work.time.at_least(at);
            let count = whole(work.run.count.into()).number();
            let time = difference(up, &work.time, at).times(&clock.twice);
            time.scaled(-1).over(&count).to(&mut work.mean);
            let more = difference(up, &work.pending, &self.v).over(&count);
            more.roughly(&clock.inverse).roughly(&work.mean)
        }
        .scaled(1)
        .also(&mut work.delta)
    }

    /// Computes the error from δ: see [`settle`](Planner::settle). Where the acceleration changes,
    /// the jerk counts like a third of J·Δt²/v in δ²; a half is added.
    fn shape(&mut self, clock: &Clock, work: &mut Work, first: bool, delta: Hand) {
        let curve = &self.curve;
        let size = self.size as i8;
        let spread = delta.bits().wrapping_add(size.into());
        // Δt·δ²/32
        let by = (size + (size << 1)).wrapping_sub(5);
        let mut error = delta.roughly(&work.mean).roughly(&work.delta).scaled(by).number();
        if !(self.is_straight() || curve.is_straight(&self.at) && curve.is_straight(&work.time)) {
            let interval = hand(&work.mean).roughly(&clock.inverse).scaled(1).number();
            let cube = hand(&interval).roughly(&interval).roughly(&interval);
            let jerk = cube.roughly(curve.half_jerk()).roughly(&work.mean);
            jerk.scaled(by).plus(&error).to(&mut error);
        }
        self.settle(clock, work, first, &error, spread);
    }

    /// Moves to the end of a ramp run, or of the fall's part of a corner.
    pub(super) fn arrive(&mut self, work: &Work) {
        self.v.set(&work.pending);
        if !self.is_straight() {
            self.at.set(&work.time);
        }
    }

    /// Plans the one step that a change of piece divides.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn corner(&mut self, clock: &Clock, work: &mut Work, last: bool) -> Planned {
        if !self.is_falling() {
            if work.stage == Stage::Begin {
                part(self.rise_part).to(&mut work.mean);
                whole(1).minus(&work.mean).to(&mut work.delta);
                if last {
                    part(self.fall_part).off(&work.delta).to(&mut work.delta);
                }
                hand(&work.delta).over(&self.v_top).to(&mut work.delta);
                work.stage = Stage::Half;
                return Planned::Again;
            }
            if self.rise_part != 0 {
                let at = &self.at;
                let time =
                    if self.ease { hand(at) } else { self.tail(at, &self.v, self.rise_part) };
                time.plus(&work.delta).to(&mut work.delta);
            }
            if last {
                self.lay_fall();
                // Until the corner is done: a change of a bent ramp can't take this back.
                self.at.set(&work.delta);
                work.stage = Stage::Begin;
                return Planned::Again;
            }
        }
        if !last {
            self.v.set(&self.v_top);
        } else if work.stage == Stage::Late {
            self.arrive(work);
            self.fall_part = 0;
        } else {
            if self.find(work, 0) {
                let time = self.tail(&work.time, &work.pending, self.fall_part);
                time.plus(&self.at).to(&mut work.delta);
                work.stage = Stage::Late;
            }
            return Planned::Again;
        }
        hand(&work.delta).times(&clock.twice).scaled(-1).to(&mut work.mean);
        // A run of one step, as long as its mean interval.
        self.rise_part = 0;
        (work.run.add, work.run.count) = (0, 1);
        Planned::Ready
    }
}

/// The larger of two numbers minus the other; `first` if `a` is the larger.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
pub(super) fn difference(first: bool, a: &Num, b: &Num) -> Hand {
    let (more, less) = if first { (a, b) } else { (b, a) };
    hand(more).minus(less)
}
