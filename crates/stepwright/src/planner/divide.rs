//! How many steps rise, stay level and fall: see the picture in `planner.rs`.

use super::{Layout, Planner};
use crate::clamp;
use crate::num::{Hand, Num, hand, whole};

impl Planner {
    /// Divides `steps` from the last pulse handed out into rise or ease, level
    /// and fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn divide(&mut self, steps: u32) {
        let mut piece = Layout::Rise;
        while piece != Layout::Check {
            piece = self.divide_piece(piece, steps);
        }
    }

    /// Does a piece of that, and tells the next.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn divide_piece(&mut self, piece: Layout, steps: u32) -> Layout {
        match piece {
            _ if self.is_bent() => return self.divide_bent(piece, steps),
            Layout::Rise => {
                let w_top = hand(&self.top).square().number();
                self.ease = !self.top.at_least(&self.v);
                self.risen = 0;
                let rise = if self.ease {
                    let (steps, part) = self.way_to(&w_top).split();
                    let rise = whole(clamp::sum(steps, (part != 0).into())).number();
                    hand(&self.v).square().minus(&w_top).over(&rise).to(&mut self.slope);
                    hand(&w_top).to(&mut self.w_from);
                    hand(&rise)
                } else {
                    hand(&self.v).square().also(&mut self.w_from).off(&w_top).over(&self.a2)
                };
                (self.rise, self.rise_part) = rise.also(&mut self.v_top).split();
                return Layout::Fall;
            }
            Layout::Fall => {
                let fall = hand(&self.top).square().minus(&self.w_end).over(&self.d2).number();
                let ramps = hand(&fall).plus(&self.v_top).number();
                hand(&self.top).to(&mut self.v_top);
                (self.fall, self.fall_part, self.level) = (0, 0, u32::MAX);
                if self.endless {
                    return Layout::Check;
                }
                if whole(steps).at_least(&ramps) {
                    (self.fall, self.fall_part) = fall.split();
                    self.level = clamp::less(clamp::less(steps, self.rise), self.fall);
                } else if self.ease {
                    self.brake();
                    self.level = clamp::less(steps, self.fall);
                } else {
                    return Layout::Spare;
                }
            }
            Layout::Spare => {
                let rest = self.way_to(&self.w_end).number();
                let spare = whole(steps).minus(&rest).number();
                let share = hand(&self.a2).plus(&self.d2).under(&self.d2);
                share.times(&spare).to(&mut self.v_top);
                return Layout::Meet;
            }
            _ => {
                let rise = self.v_top;
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
        }
        Layout::Check
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
