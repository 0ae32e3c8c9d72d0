//! Travels whose jerk is limited: the planner's ramps are [curves](super::curve).
//!
//! From rest to rest they are the fastest within their limits. A change in motion
//! first ends the ramp in progress as soon as the jerk allows; from the level that
//! is reached the rest of the travel is set up again. What already falls to its
//! target does so, and goes on from rest.

use super::curve::Curve;
use super::{Clock, Planned, Planner, Stage, Work};
use crate::num::Num;
use crate::profile::Unfit;
use crate::units::Jerk;

/// What a limited jerk adds to a planner.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Bent {
    /// The ramp in progress.
    curve: Curve,
    /// The time from its low end to the last pulse handed out.
    at: Num,
    /// The curve is that of the fall.
    falling: bool,
    /// To be set up again once the level is reached.
    again: bool,
}

impl Bent {
    /// No limit. All zeros.
    pub(super) const NONE: Bent =
        Bent { curve: Curve::STRAIGHT, at: Num::UNSET, falling: false, again: false };

    /// Sets the limit of another travel, or takes it away.
    #[expect(clippy::unnecessary_wraps)] // a planner of trapezoids refuses
    pub(super) fn limit(&mut self, jerk: Option<Jerk>) -> Result<(), Unfit> {
        // The last one may have been stopped at once, in the midst of a change.
        self.again = false;
        match jerk {
            None if !cfg!(feature = "trapezoid") => self.curve.set_no_bends(),
            jerk => self.curve.set_jerk(jerk.map_or(0, Jerk::millisteps)),
        }
        Ok(())
    }

    /// Whether the first step from rest is no longer than an interval may be.
    pub(super) fn can_start(&self, clock: &Clock) -> bool {
        !self.curve.is_bent() || self.curve.starts_within(clock.second_eighth())
    }

    /// Whether a ramp up to this speed, whose square is w, would take less than 2²² steps
    /// if it were all bends.
    pub(super) fn ends(&self, high: &Num, w: &Num) -> bool {
        // v·√(v/J) steps. Times in a ramp are good to 2⁻²⁹ of all of it: to 2⁻⁶ of an
        // interval at its high end then, and not to several intervals.
        let straight = cfg!(feature = "trapezoid") && !self.curve.is_bent();
        straight || w.times(high).over(self.curve.half_jerk()).is_below(45)
    }

    /// Whether all is to be set up again once the level is reached.
    pub(super) fn is_again(&self) -> bool {
        self.again
    }

    /// It is set up again now.
    pub(super) fn lays_out(&mut self) {
        self.again = false;
    }

    /// A run has been handed out, that ends there.
    pub(super) fn goes_to(&mut self, work: &Work) {
        self.at = work.time;
    }
}

impl Planner {
    /// Whether its ramps are curves: its jerk is limited, or there is nothing else.
    #[inline(always)]
    pub(crate) fn is_bent(&self) -> bool {
        !cfg!(feature = "trapezoid") || self.bent.curve.is_bent()
    }

    /// Divides `steps` from here, where the speed is v and level, into rise or
    /// ease, level and fall.
    ///
    /// Where the top speed is out of reach, the highest speed that rise and fall
    /// leave room for is found by Newton's method, from above, inside bounds.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn divide_bent(&mut self, steps: u32) {
        let length = Num::from(steps);
        (self.risen, self.bent.falling, self.bent.again) = (0, false, false);
        self.ease = !self.top.at_least(&self.v);
        self.v_top = self.top;
        let (mut least, mut most) = (self.v, self.top);
        for left in (0..40u8).rev() {
            if length.is_zero() && !self.endless || left == 0 {
                // A single step, which is taken; or, never seen, no speed was found.
                self.ease = false;
                self.v_top = least;
            }
            self.bent.curve.lay(&self.v_end, &self.v_top, &self.d2);
            let growth = self.bent.curve.growth();
            let fall = *self.bent.curve.length();
            (self.fall, self.fall_part) = fall.split();
            if self.ease {
                self.bent.curve.lay(&self.v_top, &self.v, &self.d2);
            } else {
                self.bent.curve.lay(&self.v, &self.v_top, &self.a2);
            }
            let growth = growth.plus(&self.bent.curve.growth());
            let both = fall.plus(self.bent.curve.length());
            if self.endless || left == 0 || length.at_least(&both) {
                let spare = length.minus(&both);
                let close = !spare.scaled(25).at_least(&length);
                if self.endless || left == 0 || self.v_top == most || close {
                    break;
                }
                least = self.v_top;
                let next = least.plus(&spare.over(&growth));
                self.v_top.set_between(&least, &next, &most);
            } else if self.ease {
                // No room: it keeps its speed, and then falls.
                self.ease = false;
                self.v_top = self.v;
                most = self.v;
            } else {
                most = self.v_top;
                let next = most.minus(&both.minus(&length).over(&growth)).minus(&most.scaled(-28));
                self.v_top.set_between(&least, &next, &most);
            }
        }
        (self.rise, self.rise_part) = self.bent.curve.length().split();
        if self.endless {
            (self.fall, self.fall_part, self.level) = (0, 0, u32::MAX);
        } else {
            self.rise = self.rise.min(steps);
            let rest = steps.wrapping_sub(self.rise);
            self.fall = self.fall.min(rest);
            self.level = rest.wrapping_sub(self.fall);
        }
        self.bent.at = if self.ease { *self.bent.curve.whole() } else { Num::ZERO };
    }

    /// Goes on after a change, or brakes: this many steps to its target.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn go_on(&mut self, left: i32) {
        if self.bent.falling {
            return;
        }
        if self.rise != 0 || self.rise_part != 0 {
            self.level_out();
        } else {
            self.v_top = self.v;
        }
        self.bent.again = true;
        if self.endless {
            return;
        }
        let mut curve = self.bent.curve;
        curve.lay(&self.v_end, &self.v_top, &self.d2);
        // A little less: what was set up to fit still does, whatever the rounding says.
        let fall = curve.length();
        (self.fall, self.fall_part) = fall.minus(&fall.scaled(-28)).split();
        // Both are less than 2²³.
        let ramps = self.rise.wrapping_add(self.fall);
        let (parts, more) = self.rise_part.overflowing_add(self.fall_part);
        // One step for both parts, or two.
        let least = u32::from(more).wrapping_add(u32::from(parts != 0));
        let room = u32::try_from(left).unwrap_or(0).saturating_sub(ramps);
        // A whole step of level more, or it falls from where it is.
        self.bent.again = room > least;
        self.level = room.max(least);
    }

    /// Ends the rise, or the ease, as soon as the jerk allows.
    fn level_out(&mut self) {
        let rest;
        if self.ease {
            let left = Num::from(self.rise).plus(&Num::part(self.rise_part));
            let gone = self.bent.curve.length().minus(&left);
            self.bent.curve.level_out_below(&mut self.bent.at);
            self.v_top = *self.bent.curve.low();
            rest = self.bent.curve.length().minus(&gone);
        } else {
            self.bent.curve.level_out(&self.bent.at);
            self.v_top = *self.bent.curve.high();
            rest = self.bent.curve.length().minus(&Num::from(self.risen));
        }
        (self.rise, self.rise_part) = rest.split();
    }

    /// Lays the fall's curve.
    fn lay_fall(&mut self) {
        self.bent.curve.lay(&self.v_end, &self.v_top, &self.d2);
        self.bent.at = *self.bent.curve.whole();
        self.bent.falling = true;
    }

    /// Where on its curve the pulse this many steps ahead is.
    fn place_after(&self, steps: u32) -> Num {
        let (whole, part) = if self.bent.falling {
            (self.fall.wrapping_sub(steps), 0)
        } else if self.ease {
            (self.rise.wrapping_sub(steps), self.rise_part)
        } else {
            (self.risen.wrapping_add(steps), 0)
        };
        Num::from(whole).plus(&Num::part(part))
    }

    /// Finds, in a call or several, when the pulse this many steps ahead comes,
    /// and its speed: `time` and `pending`. Whether it has.
    fn find(&self, work: &mut Work, steps: u16) -> bool {
        let steps = u32::from(steps);
        let x = self.place_after(steps);
        match work.stage {
            Stage::Begin => {
                let up = !self.bent.falling && !self.ease;
                // A fall begins in its corner.
                let begins = self.bent.falling && self.level != 0;
                let t = if begins { self.bent.curve.whole() } else { &self.bent.at };
                work.time = self.bent.curve.guess(t, &self.v, &Num::from(steps), &x, up);
                if x.is_zero() {
                    work.time = Num::ZERO;
                    work.pending = *self.bent.curve.low();
                    return true;
                }
                work.stage = Stage::Half;
            }
            _ => {
                let here = self.bent.curve.at(&work.time);
                work.pending = here.v;
                return self.bent.curve.correct(&mut work.time, &here, &x);
            }
        }
        false
    }

    /// A ramp run's end, mean interval and δ. Whether they are found.
    pub(super) fn follow(&mut self, clock: &Clock, work: &mut Work, first: bool) -> bool {
        if !first && !self.bent.falling {
            self.lay_fall();
        }
        if !self.find(work, work.run.count) {
            return false;
        }
        let up = work.time.at_least(&self.bent.at);
        let time = if up { work.time.minus(&self.bent.at) } else { self.bent.at.minus(&work.time) };
        work.mean = ticks(clock, &time).over(&Num::from(u32::from(work.run.count)));
        let v = &work.pending;
        let change = if up { v.minus(&self.v) } else { self.v.minus(v) };
        work.delta = work.mean.roughly(&clock.inverse).roughly(&change).scaled(1);
        true
    }

    /// What follows from δ, and it: see [`settle`](Planner::settle). Where the acceleration changes the jerk adds to δ²
    /// J·Δt²/v, for its third.
    pub(super) fn bent_shape(&self, clock: &Clock, work: &Work, size: u8) -> [Num; 3] {
        let (mean, delta) = (&work.mean, work.delta);
        let mut spread = delta.roughly(&delta);
        let straight = |t| self.bent.curve.is_straight(t);
        if !(straight(&self.bent.at) && straight(&work.time)) {
            let interval = mean.roughly(&clock.inverse).scaled(1);
            let cube = interval.roughly(&interval).roughly(&interval);
            let jerk = cube.roughly(self.bent.curve.half_jerk()).scaled(i16::from(size) << 1);
            spread = spread.plus(&jerk);
        }
        let error = spread.roughly(mean).scaled(i16::from(size) - 5);
        let growth = delta.roughly(mean).over(&Num::from(u32::from(work.run.count)));
        [delta, error, growth]
    }

    /// The one step that the level's end divides.
    pub(super) fn bent_corner(&mut self, clock: &Clock, work: &mut Work, last: bool) -> Planned {
        if work.stage == Stage::Begin && !self.bent.falling {
            let rise = Num::part(self.rise_part);
            let fall = Num::part(if last { self.fall_part } else { 0 });
            work.delta = Num::from(1).minus(&rise).minus(&fall).over(&self.v_top);
            if self.rise_part != 0 {
                let mut time = self.bent.at;
                if !self.ease {
                    time = self.bent.curve.whole().minus(&time);
                }
                work.delta = work.delta.plus(&time);
            }
            if last {
                self.lay_fall();
                // Until the corner is done: what a change can't take back.
                self.bent.at = work.delta;
                return Planned::Again;
            }
        }
        if last {
            if !self.find(work, 0) {
                return Planned::Again;
            }
            work.delta = self.bent.at.plus(&self.bent.curve.tail(&work.time));
            (self.v, self.bent.at) = (work.pending, work.time);
            self.fall_part = 0;
        } else {
            self.v = self.v_top;
        }
        work.mean = ticks(clock, &work.delta);
        self.turned(work)
    }
}

/// A time of 1000 s, in ticks.
fn ticks(clock: &Clock, time: &Num) -> Num {
    clock.twice.times(time).scaled(-1)
}
