//! One run at a time of each piece of a travel: ramps, the level, the corners between.

use super::share::{share, share_of_ramp};
use super::{Clock, Planned, Planner, Stage, Work};
use crate::num::{Hand, Num, hand, part, whole};
use crate::run::Run;
use crate::units::Ticks;

impl Planner {
    /// A ramp run: 2^size steps from v to the speed there, of the first ramp
    /// (rise or ease) or of the fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn ramp(&mut self, clock: &Clock, work: &mut Work, first: bool) -> Planned {
        if work.stage == Stage::Late {
            let steps = u32::from(work.run.count);
            if first {
                self.rise = self.rise.wrapping_sub(steps);
                self.risen = self.risen.wrapping_add(steps);
            } else {
                self.fall = self.fall.wrapping_sub(steps);
            }
            self.v = work.pending;
            self.goes_to(work);
            return Planned::Ready;
        }
        let size = self.size.min(clock.ramp_size);
        let full = 1u16 << size;
        if work.stage == Stage::Begin {
            work.run.count = share_of_ramp(if first { self.rise } else { self.fall }, full);
        }
        if self.is_bent() {
            self.follow(clock, work, first);
        } else if work.stage == Stage::Begin {
            self.speed_after(work.run.count, first).to(&mut work.pending);
            work.stage = Stage::Half;
        } else {
            // δ/N = 2·(v₂ − v₁)/(v₁ + v₂)/N = 2·slope/(v₁ + v₂)²
            hand(&work.pending).plus(&self.v).under(&clock.twice).to(&mut work.mean);
            // What follows needs few bits: the run's end is exact.
            let inverse = hand(&work.mean).roughly(&clock.inverse).number();
            let (slope, _) = self.law(first);
            let delta = hand(&inverse).roughly(&inverse).roughly(slope).scaled(1).number();
            let growth = hand(&delta).roughly(&work.mean).number();
            let delta = hand(&delta).scaled(size as i8).number();
            // Δt·δ²/32, where growth is Δt·δ/N².
            let error = hand(&growth).roughly(&delta).scaled((size as i8) * 2 - 5).number();
            self.settle(clock, work, first, [&delta, &error, &growth]);
        }
        Planned::Again
    }

    /// A ramp run of this shape is handed out next, or a shorter one is tried: by its δ, the
    /// largest error of a step between its ends and what the interval grows by in a step,
    /// both in ticks.
    pub(super) fn settle(&mut self, clock: &Clock, work: &mut Work, first: bool, shape: [&Num; 3]) {
        let [delta, error, growth] = shape;
        let size = self.size.min(clock.ramp_size);
        let up = first && !self.ease;
        let most = clock.longest_of(&work.mean) as u8;
        if size > 0 && !(size <= most && error.is_below(clock.bound) && delta.is_below(-2)) {
            self.size = size - 1;
            work.stage = Stage::Begin;
            return;
        }
        // Twice the length has eight times the error; a fall's grows by itself.
        // A run that was short for want of room says nothing of the next ones.
        if work.run.count == 1 << size {
            self.size = if size < most
                && error.is_below(clock.bound - if up { 3 } else { 4 })
                && delta.is_below(-4)
            {
                size + 1
            } else if !up && size > 0 && !error.is_below(clock.bound - 1) {
                // By (1 − 2δ)^−2½ from run to run: 1 + 8δ is more.
                let next = hand(error).roughly(delta).scaled(3).plus(error).number();
                if next.is_below(clock.bound) { size } else { size - 1 }
            } else {
                size
            };
        }
        // An even number: then neither a group's mean interval nor the spread
        // has a half to lose.
        let half = hand(growth).scaled(15).rounded_whole() as i32;
        work.run.add = if up { half.wrapping_neg() } else { half }.wrapping_shl(1);
        work.stage = Stage::Late;
    }

    /// The slope of the first ramp or the fall, and speed² where it is counted from.
    fn law(&self, first: bool) -> (&Num, &Num) {
        match (first, self.ease) {
            (true, false) => (&self.a2, &self.w_from),
            (true, true) => (&self.slope, &self.w_from),
            _ => (&self.d2, &self.w_end),
        }
    }

    /// The speed this many steps further on the first ramp or down the fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn speed_after(&self, steps: u16, first: bool) -> Hand {
        let steps = u32::from(steps);
        // What falls is computed from its end: nothing is subtracted.
        let n = match (first, self.ease) {
            (true, false) => self.risen.wrapping_add(steps),
            (true, true) => self.rise.wrapping_sub(steps),
            _ => self.fall.wrapping_sub(steps),
        };
        let (slope, w) = self.law(first);
        whole(n).times(slope).plus(w).root()
    }

    /// Takes the run that is [`Planned::Ready`], and tells how many ticks it lasts: steps with
    /// a mean interval, growing by `add`, an even number.
    ///
    /// ```text
    ///   first interval = mean − add·(N − 1)/2
    /// ```
    ///
    /// rounded down, in 2⁻¹⁶ ticks; what the N of them lack then is carried.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn take(&mut self, work: &mut Work) -> Ticks {
        work.stage = Stage::Taken;
        let Run { add, count: steps, .. } = work.run;
        let (whole, part) = work.mean.split();
        let wide = u32::from(steps);
        // Both are less than the steps of a run, 2¹⁵ at most, in 2⁻¹⁶ ticks: no
        // overflow.
        let lack = u32::from(part as u16).wrapping_mul(wide);
        let carry = self.carry.wrapping_add(lack);
        let over = (carry >> 16) as u16;
        // Mostly there is nothing to divide.
        let more = if over < steps { 0 } else { over.checked_div(steps).unwrap_or(0) };
        self.carry = carry.wrapping_sub(u32::from(more.wrapping_mul(steps)) << 16);
        // It is less than δ of the interval, and fits: see `longest_of`.
        let spread = (add >> 1).wrapping_mul(wide.wrapping_sub(1) as i32);
        // What the first interval has beyond the whole ticks of the mean.
        let beyond = ((part >> 16) as i32).wrapping_add(more.into()).wrapping_sub(spread);
        work.run.ticks = whole.wrapping_add_signed(beyond >> 16);
        work.run.part = beyond as u16;
        whole.wrapping_mul(wide)
    }

    /// Forgets the corners that are none: p of a step on a ramp, the rest of it at the top
    /// speed, last longer than a level step by
    ///
    /// ```text
    ///   p²·2f·slope/(8·v³)                p² ≤ 1
    /// ```
    ///
    /// ticks. 1/128 of the largest error is let pass: 1/16 tick at 16 MHz.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn straighten(&mut self, clock: &Clock) {
        let v = &self.v_top;
        let cube = hand(v).roughly(v).roughly(v).roughly(&clock.inverse);
        let steepest = cube.scaled(clock.bound - 4).number();
        if steepest.at_least(&self.a2) {
            self.rise_part = 0;
        }
        if steepest.at_least(&self.d2) {
            self.fall_part = 0;
        }
    }

    /// A level run.
    pub(super) fn cruise(&mut self, clock: &Clock, work: &mut Work) -> Planned {
        match work.stage {
            Stage::Begin => {
                let v = hand(&self.v_top).also(&mut self.v);
                v.under(&clock.twice).scaled(-1).to(&mut work.mean);
                work.stage = Stage::Half;
                return Planned::Again;
            }
            Stage::Half => {
                let corner = self.fall_part != 0 && !self.endless;
                let room = self.level.wrapping_sub(corner.into());
                let size = clock.level_size.min(clock.longest_of(&work.mean) as u8);
                (work.run.add, work.run.count) = (0, share(room, 1 << size));
                // Where there is no corner the fall may begin with a part of one.
                if u32::from(work.run.count) == self.level && !self.is_bent() {
                    self.speed_after(0, false).to(&mut work.pending);
                    work.stage = Stage::Late;
                    return Planned::Again;
                }
            }
            Stage::Late | Stage::Last | Stage::Taken => self.v = work.pending,
        }
        if !self.endless {
            self.level = self.level.wrapping_sub(work.run.count.into());
        }
        Planned::Ready
    }

    /// The one step that a change of piece divides.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn corner(&mut self, clock: &Clock, work: &mut Work, last: bool) -> Planned {
        if self.is_bent() {
            return self.bent_corner(clock, work, last);
        }
        // Before a fall the speed is that which takes its steps, also where it has no part.
        let last = self.level == 1 && !self.endless;
        let rise = self.rise_part;
        let fall = if last { self.fall_part } else { 0 };
        let of_step = match work.stage {
            Stage::Begin => {
                whole(0).to(&mut work.pending);
                hand(&self.v).to(&mut work.mean);
                work.stage = Stage::Half;
                rise
            }
            Stage::Half => {
                hand(&self.v_top).to(&mut work.mean);
                work.stage = if last { Stage::Late } else { Stage::Last };
                // Of the whole step: the parts are in 2⁻³², and not both 0. Where the ramps take
                // all of it, what they were rounded to may be a little more.
                let (ramps, over) = rise.overflowing_add(fall);
                if over { 0 } else { 0u32.wrapping_sub(ramps) }
            }
            Stage::Late => {
                self.speed_after(0, false).to(&mut work.mean);
                work.stage = Stage::Last;
                fall
            }
            Stage::Last | Stage::Taken => {
                hand(&work.mean).to(&mut self.v);
                hand(&work.pending).to(&mut work.mean);
                if last {
                    self.fall_part = 0;
                }
                return self.turned(work);
            }
        };
        // A part takes its time at the mean of the top speed and the one at its other end.
        let both = hand(&work.mean).plus(&self.v_top).number();
        let time = part(of_step).times(&clock.twice).over(&both);
        time.plus(&work.pending).to(&mut work.pending);
        Planned::Again
    }

    /// The corner is a run of one step, as long as its mean interval.
    pub(super) fn turned(&mut self, work: &mut Work) -> Planned {
        self.rise_part = 0;
        if !self.endless {
            self.level = self.level.wrapping_sub(1);
        }
        (work.run.add, work.run.count) = (0, 1);
        Planned::Ready
    }
}
