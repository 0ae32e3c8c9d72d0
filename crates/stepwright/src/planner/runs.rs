//! Plans one run at a time of each piece of a travel: ramps, level, corners.

use super::share::{share, share_of_ramp};
use super::{Clock, Planned, Planner, Stage, Work};
use crate::num::{Num, hand};
use crate::run::Run;
use crate::units::Ticks;

impl Planner {
    /// A ramp run: 2^size steps from v, of the first ramp (rise or ease) or of the fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn ramp(&mut self, clock: &Clock, work: &mut Work, first: bool) -> Planned {
        if work.stage == Stage::Late {
            work.run.add = 0;
            if work.run.count != 1 {
                // An even number: then neither a group's mean interval nor the spread loses a half.
                let half = hand(&work.delta).roughly(&work.mean).scaled(15).rounded_whole() as i32;
                let up = first && !self.ease;
                work.run.add = if up { half.wrapping_neg() } else { half }.wrapping_shl(1);
            }
            let steps = u32::from(work.run.count);
            let left = if first { &mut self.rise } else { &mut self.fall };
            *left = left.wrapping_sub(steps);
            self.risen = self.risen.wrapping_add(steps);
            self.arrive(work);
            self.reach();
            return Planned::Ready;
        }
        if work.stage == Stage::Begin {
            let room = if first { self.rise } else { self.fall };
            work.run.count = share_of_ramp(room, 1 << self.size);
        }
        self.follow(clock, work, first);
        Planned::Again
    }

    /// Accepts a ramp run with this δ, or tries a shorter one. Decides by the largest error of a
    /// step within the run, in ticks, and by the spread of its intervals over their mean, which is
    /// less than 2^spread.
    pub(super) fn settle(
        &mut self,
        clock: &Clock,
        work: &mut Work,
        first: bool,
        error: &Num,
        spread: i16,
    ) {
        let size = self.size;
        let up = first && !self.ease;
        let most = clock.longest_of(&work.mean) as u8;
        let off = error.bits().wrapping_sub(clock.bound.into());
        if size > 0 && !(size <= most && off <= 0 && spread <= -2) {
            self.size = size - 1;
            work.stage = Stage::Begin;
            return;
        }
        // Twice the length has eight times the error; that of a fall grows by itself. A run that
        // was short for lack of room says nothing about the next ones.
        if work.run.count == 1 << size {
            let longer = size < most.min(clock.ramp_size) && spread <= -4;
            if longer && off <= if up { -3 } else { -4 } {
                self.size = size + 1;
            } else if !up && size > 0 && off >= 0 {
                // It grows by (1 − 2δ)^−2½ from run to run; 1 + 8δ is more.
                let next = hand(error).roughly(&work.delta).scaled(size as i8 + 3).plus(error);
                if !next.below(clock.bound) {
                    self.size = size - 1;
                }
            }
        }
        work.stage = Stage::Late;
    }

    /// Takes the run that is [`Planned::Ready`], and returns the ticks that it lasts: steps with a
    /// mean interval, growing by `add`, an even number.
    ///
    /// ```text
    ///   first interval = mean − add·(N − 1)/2
    /// ```
    ///
    /// rounded down, in 2⁻¹⁶ ticks; the rest of the N intervals is carried.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn take(&mut self, work: &mut Work) -> Ticks {
        work.stage = Stage::Taken;
        let Run { add, count: steps, .. } = work.run;
        let (whole, part) = work.mean.split();
        let wide = u32::from(steps);
        // Both are less than the steps of a run, at most 2¹⁵, in 2⁻¹⁶ ticks: no overflow.
        let lack = u32::from(part as u16).wrapping_mul(wide);
        let carry = self.carry.wrapping_add(lack);
        let over = (carry >> 16) as u16;
        // Mostly there is nothing to divide.
        let more = if over < steps { 0 } else { over.checked_div(steps).unwrap_or(0) };
        self.carry = carry.wrapping_sub(u32::from(more.wrapping_mul(steps)) << 16);
        // The spread is less than δ of the interval, and fits: see `longest_of`.
        let spread = (add >> 1).wrapping_mul(wide.wrapping_sub(1) as i32);
        // What the first interval has beyond the whole ticks of the mean.
        let beyond = ((part >> 16) as i32).wrapping_add(more.into()).wrapping_sub(spread);
        work.run.ticks = whole.wrapping_add_signed(beyond >> 16);
        work.run.part = beyond as u16;
        whole.wrapping_mul(wide)
    }

    /// A run of the level, or a corner, which is one step of it.
    pub(super) fn level(&mut self, clock: &Clock, work: &mut Work) -> Planned {
        let last = self.level == 1 && self.fall_part != 0 && !self.endless;
        let planned = if self.rise_part != 0 || last {
            self.corner(clock, work, last)
        } else {
            self.cruise(clock, work)
        };
        if planned == Planned::Ready && !self.endless {
            self.level = self.level.wrapping_sub(work.run.count.into());
        }
        planned
    }

    /// A level run.
    fn cruise(&mut self, clock: &Clock, work: &mut Work) -> Planned {
        if work.stage == Stage::Begin {
            let v = hand(&self.v_top).also(&mut self.v);
            v.under(&clock.twice).scaled(-1).to(&mut work.mean);
            work.stage = Stage::Half;
            return Planned::Again;
        }
        let corner = self.fall_part != 0 && !self.endless;
        let room = self.level.wrapping_sub(corner.into());
        let size = clock.level_size.min(clock.longest_of(&work.mean) as u8);
        (work.run.add, work.run.count) = (0, share(room, 1 << size));
        Planned::Ready
    }
}
