//! How many steps rise, stay level and fall: see the picture in `planner.rs`.

use super::Planner;
use crate::clamp;
use crate::num::{Hand, Num, hand, whole};

impl Planner {
    /// Divides `steps` from the last pulse handed out into rise or ease, level
    /// and fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn divide(&mut self, steps: u32) {
        if self.is_bent() {
            self.divide_bent(steps);
            return;
        }
        let w_top = hand(&self.top).also(&mut self.v_top).square().number();
        self.ease = !self.top.at_least(&self.v);
        self.risen = 0;
        let rise = if self.ease {
            let (steps, part) = self.way_to(&w_top).split();
            let rise = whole(clamp::sum(steps, (part != 0).into())).number();
            hand(&self.v).square().minus(&w_top).over(&rise).to(&mut self.slope);
            hand(&w_top).to(&mut self.w_from);
            rise
        } else {
            hand(&self.v).square().also(&mut self.w_from).off(&w_top).over(&self.a2).number()
        };
        (self.rise, self.rise_part) = rise.split();
        (self.fall, self.fall_part, self.level) = (0, 0, u32::MAX);
        if self.endless {
            return;
        }
        let fall = hand(&w_top).minus(&self.w_end).over(&self.d2).number();
        let ramps = hand(&fall).plus(&rise).number();
        if whole(steps).at_least(&ramps) {
            (self.fall, self.fall_part) = fall.split();
            self.level = clamp::less(clamp::less(steps, self.rise), self.fall);
        } else if self.ease {
            self.brake();
            self.level = clamp::less(steps, self.fall);
        } else {
            self.meet(steps);
        }
    }

    /// The top speed is out of reach: the rise meets the fall.
    fn meet(&mut self, steps: u32) {
        let rest = self.way_to(&self.w_end).number();
        let spare = whole(steps).minus(&rest).number();
        let rise = hand(&self.a2).plus(&self.d2).under(&self.d2).times(&spare).number();
        hand(&rise).times(&self.a2).plus(&self.w_from).root().to(&mut self.v_top);
        let (whole, part) = rise.split();
        self.rise = whole.min(steps);
        self.fall = steps.wrapping_sub(self.rise);
        (self.level, self.rise_part) = (0, 0);
        if part != 0 && self.fall != 0 {
            (self.level, self.fall) = (1, self.fall.wrapping_sub(1));
            (self.rise_part, self.fall_part) = (part, 0u32.wrapping_sub(part));
        }
    }

    /// Steps from the last pulse handed out to a lower speed, of this square, along the
    /// deceleration.
    ///
    /// A part in 2²⁸ of v² is left out: what has begun to fall to its target is
    /// still able to reach it, whatever the rounding says.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn way_to(&self, end: &Num) -> Hand {
        let w = hand(&self.v).square().number();
        hand(&w).scaled(-28).off(&w).minus(end).over(&self.d2)
    }

    /// Brakes from the last pulse handed out, in as few steps as the ramp
    /// allows: on at the same speed for the part of a step that is left over,
    /// then the fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn brake(&mut self) {
        self.endless = false;
        if self.is_bent() {
            self.go_on(0);
            return;
        }
        (self.rise, self.rise_part) = (0, 0);
        (self.fall, self.fall_part) = self.way_to(&self.w_end).split();
        self.level = u32::from(self.fall_part != 0);
        hand(&self.v).to(&mut self.v_top);
    }
}
