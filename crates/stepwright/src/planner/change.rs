//! Changes of a travel in progress.
//!
//! A straight ramp ends at any pulse, and the rest of the travel is set up from there at once. A
//! bent ramp first ends as soon as the jerk allows; the rest is set up again from the level that is
//! reached. A fall to the target under a jerk limit is completed, and the travel continues from
//! rest.

use super::{Layout, Planner};
use crate::clamp;
use crate::num::hand;

impl Planner {
    /// Sets the travel up again from the last pulse handed out: this many steps to its target, less
    /// than 0 if the target is behind. The axis brakes if it would overshoot. Its top speed is
    /// searched as its runs are planned.
    pub(crate) fn resume(&mut self, left: i32) {
        self.go_on(left.max(0) as u32);
    }

    /// Searches the top speed at once, for a caller that asks what is left. Bent ramps first have
    /// to end.
    pub(crate) fn seek(&mut self) {
        if self.is_straight() && self.is_again() {
            self.divide(self.level.wrapping_add(self.fall));
        }
    }

    /// Brakes from the last pulse handed out, and ends no later than the travel would: see
    /// [`stop`](Planner::stop).
    ///
    /// A stop of bent ramps might end later: a bent ease first has to end, at a higher speed than
    /// it leads to, and a rise that was to end with this run is longer by a fraction of a step
    /// because its speed is rounded. Then the travel itself is the shortest stop, and continues.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn brake(&mut self) {
        if self.is_straight() {
            return self.stop();
        }
        let travel = *self;
        self.stop();
        if self.steps_left() > travel.steps_left() {
            *self = travel;
        }
    }

    /// Brakes in as few steps as the ramp allows: at the same speed for the remaining fraction of a
    /// step, then the fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn stop(&mut self) {
        self.endless = false;
        self.go_on(0);
    }

    /// Continues after a change, or brakes: this many steps to the target.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn go_on(&mut self, left: u32) {
        if self.is_straight() {
            (self.rise, self.rise_part) = (0, 0);
        } else if self.is_falling() {
            return;
        }
        if self.rise | self.rise_part != 0 {
            self.level_out();
        } else {
            self.v_top.set(&self.v);
        }
        self.piece = Layout::Rise;
        if self.endless {
            return;
        }
        (self.fall, self.fall_part) = if self.is_straight() {
            // As below, with one division.
            let w_end = hand(&self.v_end).square().number();
            let w = hand(&self.v_top).square().number();
            hand(&w).scaled(-28).off(&w).minus(&w_end).over(&self.d2).split()
        } else {
            let mut fall = self.curve;
            fall.lay(&self.v_end, &self.v_top, &self.d2, false);
            fall.scant(&self.v_top, &self.d2).split()
        };
        let (parts, more) = self.rise_part.overflowing_add(self.fall_part);
        // One step for both fractions, or two.
        let least = u32::from(u8::from(more).wrapping_add(u8::from(parts != 0)));
        // A fall may be longer than can be counted; with a bent rise it is shorter than 2²³ steps.
        let ramps = self.rise.wrapping_add(self.fall);
        let room = clamp::less(left, ramps);
        let more = clamp::less(room, least);
        self.level = more.wrapping_add(least);
        // Falls from here if it must; with a bent rise also if there is no whole step of level
        // beyond the corners.
        if (if self.is_straight() { room } else { more }) == 0 {
            self.piece = Layout::Speeds;
        }
    }

    /// Ends a bent rise or ease as soon as the jerk allows.
    fn level_out(&mut self) {
        let mut gone = self.place_after(0).number();
        let curve = &mut self.curve;
        if self.ease {
            hand(curve.length()).minus(&gone).to(&mut gone);
        }
        curve.level_out(&mut self.at, !self.ease);
        let level = if self.ease { curve.low() } else { curve.high() };
        self.v_top.set(level);
        (self.rise, self.rise_part) = hand(curve.length()).minus(&gone).split();
        self.reach();
    }
}
