//! Travels whose jerk is limited: the planner's ramps are [curves](super::curve).
//!
//! From rest to rest they are the fastest within their limits. A change in motion
//! first ends the ramp in progress as soon as the jerk allows; from the level that
//! is reached the rest of the travel is set up again. What already falls to its
//! target does so, and goes on from rest.

use super::curve::Curve;
use super::{Clock, Layout, Planned, Planner, Stage, Work};
use crate::num::{Num, hand, part, whole};
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
    /// To be set up again once the level is reached: from this piece on, if it is.
    again: bool,
    piece: Layout,
}

impl Bent {
    /// No limit. All zeros.
    pub(super) const NONE: Bent = Bent {
        curve: Curve::STRAIGHT,
        at: Num::UNSET,
        falling: false,
        again: false,
        piece: Layout::Speeds,
    };

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
        straight || hand(w).times(high).over(self.curve.half_jerk()).number().is_below(45)
    }

    /// Whether all is to be set up again once the level is reached.
    pub(super) fn is_again(&self) -> bool {
        self.again
    }
}

impl Planner {
    /// Whether its ramps are curves: its jerk is limited, or there is nothing else.
    #[inline(always)]
    pub(crate) fn is_bent(&self) -> bool {
        !cfg!(feature = "trapezoid") || self.bent.curve.is_bent()
    }

    /// A ramp run has been handed out, that ends there.
    pub(super) fn goes_to(&mut self, work: &Work) {
        hand(&work.time).to(&mut self.bent.at);
        if self.is_bent() && !self.bent.falling {
            self.reach();
        }
    }

    /// At the end of a rise the speed is that of its curve: pulses are found by their times,
    /// and their speeds are told to some 2⁻¹⁵. From here a change may set up the rest.
    fn reach(&mut self) {
        if self.rise == 0 && self.rise_part == 0 {
            hand(&self.v_top).to(&mut self.v);
        }
    }

    /// Does a piece of setting up what is left once more, on the level.
    pub(super) fn divide_again(&mut self) {
        self.bent.piece = self.divide_bent(self.bent.piece, self.level.wrapping_add(self.fall));
    }

    /// Does a piece of dividing `steps` from here, where the speed is v and level, into rise
    /// or ease, level and fall, and tells the next.
    ///
    /// Where the top speed is out of reach, the highest speed that rise and fall
    /// leave room for is found by Newton's method, from above, inside bounds. Until it is
    /// found they are in `w_from` and `w_end`, of which a curve has no need; the length of the
    /// fall is in `at`, what it grows by in `slope`, and how often may still be tried in `risen`.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn divide_bent(&mut self, piece: Layout, steps: u32) -> Layout {
        match piece {
            Layout::Fall => {
                if self.risen == 0 {
                    // A single step, which is taken; or there is no speed between the two.
                    self.ease = false;
                    hand(&self.w_from).to(&mut self.v_top);
                }
                self.curve_of_fall();
                hand(self.bent.curve.length()).to(&mut self.bent.at);
                Layout::Spare
            }
            Layout::Spare => {
                self.bent.curve.growth().to(&mut self.slope);
                Layout::Meet
            }
            Layout::Meet => {
                let curve = &mut self.bent.curve;
                if self.ease {
                    curve.lay(&self.v_top, &self.v, &self.d2);
                } else {
                    curve.lay(&self.v, &self.v_top, &self.a2);
                }
                Layout::Join
            }
            Layout::Join => self.meet(steps),
            // The first: also where a change begins it once more.
            _ => {
                (self.risen, self.bent.falling) = (TRIES, false);
                self.ease = !self.top.at_least(&self.v);
                hand(&self.v).to(&mut self.w_from);
                hand(&self.top).also(&mut self.w_end).to(&mut self.v_top);
                if steps == 0 && !self.endless {
                    self.risen = 0;
                }
                Layout::Fall
            }
        }
    }

    /// Rise and fall are laid: they fit, or the next speed is tried.
    fn meet(&mut self, steps: u32) -> Layout {
        let last = self.endless || self.risen == 0;
        self.risen = self.risen.wrapping_sub(1);
        let curve = &self.bent.curve;
        let growth = curve.growth().plus(&self.slope).number();
        let mut off = hand(curve.length()).plus(&self.bent.at).number();
        let (least, most) = (&mut self.w_from, &mut self.w_end);
        let length = whole(steps).number();
        if last || length.at_least(&off) {
            hand(&length).minus(&off).to(&mut off);
            if last || self.v_top == *most || !hand(&off).scaled(25).at_least(&length) {
                self.share(steps);
                return Layout::Check;
            }
            hand(&self.v_top).to(least);
            hand(&off).over(&growth).plus(least).to(&mut off);
            if least.at_least(&off) {
                // The next number: where a curve is steep it is too much, and the last to try.
                hand(least).scaled(-31).plus(least).to(&mut off);
            }
        } else if self.ease {
            // No room: it keeps its speed, and then falls.
            self.ease = false;
            hand(&self.v).also(most).to(&mut self.v_top);
            return Layout::Fall;
        } else {
            hand(&self.v_top).to(most);
            hand(&off).minus(&length).over(&growth).off(most).to(&mut off);
            hand(most).scaled(-28).off(&off).to(&mut off);
        }
        self.v_top.set_between(least, &off, most);
        if least.at_least(&self.v_top) {
            self.risen = 0;
        }
        Layout::Fall
    }

    /// The speed is found: rise, level and fall take their steps.
    fn share(&mut self, steps: u32) {
        self.risen = 0;
        self.bent.again = false;
        (self.fall, self.fall_part) = self.bent.at.split();
        (self.rise, self.rise_part) = self.bent.curve.length().split();
        if self.endless {
            (self.fall, self.fall_part, self.level) = (0, 0, u32::MAX);
        } else {
            self.rise = self.rise.min(steps);
            let rest = steps.wrapping_sub(self.rise);
            self.fall = self.fall.min(rest);
            self.level = rest.wrapping_sub(self.fall);
        }
        let at = if self.ease { hand(self.bent.curve.whole()) } else { whole(0) };
        at.to(&mut self.bent.at);
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
            hand(&self.v).to(&mut self.v_top);
        }
        (self.bent.again, self.bent.piece) = (true, Layout::Rise);
        if self.endless {
            return;
        }
        let curve = self.bent.curve;
        self.curve_of_fall();
        // A little less: what was set up to fit still does, whatever the rounding says.
        let fall = *self.bent.curve.length();
        self.bent.curve = curve;
        (self.fall, self.fall_part) = hand(&fall).scaled(-28).off(&fall).split();
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
        let curve = &mut self.bent.curve;
        let mut gone = if self.ease {
            let left = part(self.rise_part).number();
            let left = whole(self.rise).plus(&left).number();
            hand(curve.length()).minus(&left).number()
        } else {
            whole(self.risen).number()
        };
        curve.level_out(&mut self.bent.at, !self.ease);
        let level = if self.ease { curve.low() } else { curve.high() };
        hand(level).to(&mut self.v_top);
        hand(curve.length()).minus(&gone).to(&mut gone);
        (self.rise, self.rise_part) = gone.split();
        self.reach();
    }

    /// Lays the curve of a fall from the top speed.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn curve_of_fall(&mut self) {
        self.bent.curve.lay(&self.v_end, &self.v_top, &self.d2);
    }

    /// Lays the fall's curve.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn lay_fall(&mut self) {
        self.curve_of_fall();
        hand(self.bent.curve.whole()).to(&mut self.bent.at);
        self.bent.falling = true;
    }

    /// Where on its curve the pulse this many steps ahead is.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn place_after(&self, steps: u16) -> Num {
        let steps = u32::from(steps);
        let (n, rest) = if self.bent.falling {
            (self.fall.wrapping_sub(steps), 0)
        } else if self.ease {
            (self.rise.wrapping_sub(steps), self.rise_part)
        } else {
            (self.risen.wrapping_add(steps), 0)
        };
        let rest = part(rest).number();
        whole(n).plus(&rest).number()
    }

    /// Finds, in several calls, when the pulse this many steps ahead comes,
    /// and its speed: `time` and `pending`. Whether it has.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn find(&self, work: &mut Work, steps: u16) -> bool {
        let x = self.place_after(steps);
        let curve = &self.bent.curve;
        match work.stage {
            Stage::Begin => {
                if x.is_zero() {
                    whole(0).to(&mut work.time);
                    hand(curve.low()).to(&mut work.pending);
                    return true;
                }
                // A fall begins in its corner.
                let begins = self.bent.falling && self.level != 0;
                let t = if begins { curve.whole() } else { &self.bent.at };
                hand(t).to(&mut work.time);
                let up = !self.bent.falling && !self.ease;
                let steps = whole(steps.into()).number();
                curve.guess(&mut work.time, &self.v, &steps, &x, up);
                work.stage = Stage::Half;
            }
            _ => {
                curve.at(&work.time, &mut work.pending, &mut work.mean);
                return curve.correct(&mut work.time, &work.pending, &work.mean, &x);
            }
        }
        false
    }

    /// A piece of planning a ramp run: its end, its mean interval and δ, and what follows.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn follow(&mut self, clock: &Clock, work: &mut Work, first: bool) {
        if !first && !self.bent.falling {
            self.lay_fall();
        }
        if self.find(work, work.run.count) {
            self.measure(clock, work);
            self.shape(clock, work, first);
        }
    }

    /// The mean interval of a ramp run and its δ.
    fn measure(&self, clock: &Clock, work: &mut Work) {
        let at = &self.bent.at;
        let up = work.time.at_least(at);
        let count = whole(work.run.count.into()).number();
        difference(up, &work.time, at, &mut work.mean);
        hand(&work.mean).times(&clock.twice).scaled(-1).over(&count).to(&mut work.mean);
        difference(up, &work.pending, &self.v, &mut work.delta);
        let delta = hand(&work.mean).roughly(&clock.inverse).roughly(&work.delta).scaled(1);
        delta.to(&mut work.delta);
    }

    /// What follows from δ: see [`settle`](Planner::settle). Where the acceleration changes
    /// the jerk adds to δ² J·Δt²/v, for its third.
    fn shape(&mut self, clock: &Clock, work: &mut Work, first: bool) {
        let curve = &self.bent.curve;
        let size = self.size.min(clock.ramp_size);
        let delta = hand(&work.delta).number();
        let mut error = hand(&delta).roughly(&delta).number();
        if !(curve.is_straight(&self.bent.at) && curve.is_straight(&work.time)) {
            let interval = hand(&work.mean).roughly(&clock.inverse).scaled(1).number();
            let cube = hand(&interval).roughly(&interval).roughly(&interval);
            let jerk = cube.roughly(curve.half_jerk()).scaled((size << 1) as i8);
            jerk.plus(&error).to(&mut error);
        }
        hand(&error).roughly(&work.mean).scaled((size as i8).wrapping_sub(5)).to(&mut error);
        let count = whole(work.run.count.into()).number();
        let growth = hand(&delta).roughly(&work.mean).over(&count).number();
        self.settle(clock, work, first, [&delta, &error, &growth]);
    }

    /// The one step that the level's end divides.
    pub(super) fn bent_corner(&mut self, clock: &Clock, work: &mut Work, last: bool) -> Planned {
        if work.stage == Stage::Begin && !self.bent.falling {
            let rise = part(self.rise_part).number();
            let fall = part(if last { self.fall_part } else { 0 }).number();
            whole(1).minus(&rise).minus(&fall).over(&self.v_top).to(&mut work.delta);
            if self.rise_part != 0 {
                let time = if self.ease {
                    hand(&self.bent.at).number()
                } else {
                    self.bent.curve.tail(&self.bent.at).number()
                };
                hand(&time).plus(&work.delta).to(&mut work.delta);
            }
            if last {
                self.lay_fall();
                // Until the corner is done: what a change can't take back.
                hand(&work.delta).to(&mut self.bent.at);
                return Planned::Again;
            }
        }
        if last {
            if !self.find(work, 0) {
                return Planned::Again;
            }
            self.bent.curve.tail(&work.time).plus(&self.bent.at).to(&mut work.delta);
            hand(&work.pending).to(&mut self.v);
            hand(&work.time).to(&mut self.bent.at);
            self.fall_part = 0;
        } else {
            hand(&self.v_top).to(&mut self.v);
        }
        hand(&work.delta).times(&clock.twice).scaled(-1).to(&mut work.mean);
        self.turned(work)
    }
}

/// The larger of two less the other: the first is, or it is not.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn difference(first: bool, a: &Num, b: &Num, to: &mut Num) {
    let (more, less) = if first { (a, b) } else { (b, a) };
    hand(more).minus(less).to(to);
}

/// How often a speed is looked for.
const TRIES: u32 = 39;
