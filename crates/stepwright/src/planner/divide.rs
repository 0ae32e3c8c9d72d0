//! Divides a travel into rise, level and fall: see the diagram in `planner.rs`.

use super::curve::move_by;
use super::ramp::difference;
use super::{Layout, Planner};
use crate::clamp;
use crate::num::{hand, whole};

impl Planner {
    /// Divides `steps` from the last pulse handed out into rise or ease, level and fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn divide(&mut self, steps: u32) {
        let mut piece = Layout::Rise;
        while piece != Layout::Check {
            piece = self.divide_piece(piece, steps);
        }
    }

    /// Does a piece of setting up the rest again, on the level.
    pub(super) fn divide_again(&mut self) {
        let steps = self.level.wrapping_add(self.fall);
        self.piece = self.divide_piece(self.piece, steps);
    }

    /// Does a piece of dividing `steps` from here, at the constant speed v, into rise or ease,
    /// level and fall. Returns the next piece.
    ///
    /// If the top speed is out of reach, the highest speed that leaves room for rise and fall
    /// follows from the steps if both ramps are straight. Else it is searched by Newton's method
    /// within bounds. Until it is found the bounds are in `w_from` and `most`, the length of the
    /// fall is in `at`, and its growth in `slope`.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn divide_piece(&mut self, piece: Layout, steps: u32) -> Layout {
        // Each ramp takes less than half of that.
        let steps = if self.endless { u32::MAX } else { steps };
        match piece {
            Layout::Fall => {
                if self.tries == 0 {
                    // A single step, which is taken; or there is no speed between the bounds.
                    self.ease = false;
                    self.v_top.set(&self.w_from);
                }
                self.curve_of_fall();
                self.at.set(self.curve.length());
                whole(0).to(&mut self.slope);
                if self.is_straight() { Layout::Meet } else { Layout::Spare }
            }
            Layout::Spare | Layout::Join if self.is_straight() => {
                self.peak_of_straight(piece, steps)
            }
            Layout::Spare | Layout::Join => {
                self.curve.growth().plus(&self.slope).to(&mut self.slope);
                if piece == Layout::Spare { Layout::Meet } else { Layout::Try }
            }
            Layout::Meet => {
                let (straight, curve) = (self.is_straight(), &mut self.curve);
                if self.ease {
                    curve.lay(&self.v_top, &self.v, &self.d2, straight);
                    if straight {
                        curve.round_up(&self.v, &self.d2);
                    }
                } else {
                    curve.lay(&self.v, &self.v_top, &self.a2, straight);
                }
                if straight { Layout::Try } else { Layout::Join }
            }
            Layout::Try => self.meet(steps),
            // The first piece: also if a change starts the division again.
            _ => {
                (self.tries, self.piece) = (TRIES, Layout::Speeds);
                self.ease = !self.top.at_least(&self.v);
                self.w_from.set(&self.v);
                self.v_top.set(&self.top);
                self.try_at_most();
                if steps == 0 {
                    self.tries = 0;
                }
                Layout::Fall
            }
        }
    }

    /// Limits the search to speeds up to the present one.
    fn try_at_most(&mut self) {
        if !self.is_straight() {
            self.most.set(&self.v_top);
        }
    }

    /// Rise and fall are computed: ends the search if they fit, else sets the next speed to try.
    fn meet(&mut self, steps: u32) -> Layout {
        let ramps = hand(self.curve.length()).plus(&self.at).number();
        let length = whole(steps).number();
        let last = self.tries == 0;
        let fits = last || length.at_least(&ramps);
        let mut off = difference(fits, &length, &ramps).number();
        if fits && (last || self.is_straight() || self.v_top.at_least(&self.most)) {
            self.share(steps);
            return Layout::Check;
        }
        self.tries = self.tries.wrapping_sub(1);
        if !fits && self.ease {
            // No room: keeps the speed, then falls.
            self.ease = false;
            self.v_top.set(&self.v);
            self.try_at_most();
            return Layout::Fall;
        }
        if self.is_straight() {
            return Layout::Spare;
        }
        // The next number at least: where a curve is steep this is too much, and the last to try.
        // Or a little less.
        let (bound, less) = if fits { (&mut self.w_from, -30) } else { (&mut *self.most, -28) };
        let v = &self.v_top;
        hand(&off).over(&self.slope).times(v).scaled(1).to(&mut off);
        let mut w = hand(v).also(bound).square().number();
        if fits && w.at_least(&off.scaled(27)) {
            // Near enough: v would be higher by at most 2⁻²⁸ of itself.
            self.share(steps);
            return Layout::Check;
        }
        hand(&w).scaled(less).plus(&off).to(&mut off);
        move_by(fits, &mut w, &off);
        hand(&w).root().to(&mut w);
        // A sixteenth of the way, less if there is less room for these ramps.
        let (less, more) = if fits { (&ramps, &length) } else { (&length, &ramps) };
        let part = hand(less).over(more).scaled(-4).number();
        self.v_top.set_between(&self.w_from, &w, &self.most, &part);
        if self.w_from.at_least(&self.v_top) {
            self.tries = 0;
        }
        Layout::Fall
    }

    /// Sets the last speed to try: the highest speed of straight ramps in this many steps, or the
    /// present one.
    ///
    /// ```text
    ///   v_top²·(2a + 2d) = steps·2a·2d + v²·2d + v_end²·2a
    /// ```
    ///
    /// Reduced by 2⁻²⁸, so that it fits. In two pieces: the right side is in `slope` in between.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn peak_of_straight(&mut self, piece: Layout, steps: u32) -> Layout {
        let (up, down, peak) = (&self.a2, &self.d2, &mut self.slope);
        if piece == Layout::Spare {
            hand(&self.v_end).square().times(up).to(peak);
            let rest = hand(&self.v).square().times(down).plus(peak).number();
            whole(steps).times(up).times(down).plus(&rest).to(peak);
            return Layout::Join;
        }
        let both = hand(up).plus(down).number();
        hand(peak).over(&both).to(peak);
        hand(peak).scaled(-28).off(peak).root().to(peak);
        if !self.w_from.at_least(peak) {
            self.w_from.set(peak);
        }
        self.tries = 0;
        Layout::Fall
    }

    /// The speed is found: assigns the steps to rise, level and fall.
    fn share(&mut self, steps: u32) {
        self.risen = 0;
        let curve = &self.curve;
        (self.rise, self.rise_part) = curve.length().split();
        (self.fall, self.fall_part) = self.at.split();
        let rest = clamp::less(steps, self.rise);
        self.rise = steps.wrapping_sub(rest);
        self.level = clamp::less(rest, self.fall);
        self.fall = rest.wrapping_sub(self.level);
        let low = if self.ease { &self.v_top } else { &self.v };
        hand(low).square().to(&mut self.w_from);
        if self.ease {
            if !self.is_straight() {
                self.at.set(curve.whole());
            }
            hand(&self.v).square().minus(&self.w_from).over(curve.length())
        } else {
            whole(0).to(&mut self.at);
            hand(&self.a2)
        }
        .to(&mut self.slope);
    }
}

/// The most speeds that are tried.
const TRIES: u8 = 39;
