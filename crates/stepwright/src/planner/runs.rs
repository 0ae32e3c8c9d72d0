//! One run at a time of each piece of a travel: ramps, the level, the corners between.

use super::share::{share, share_of_ramp};
use super::{Clock, Planned, Planner, Stage, Work};
use crate::num::{Hand, Num, hand, part, whole};
use crate::run::Run;

impl Planner {
    /// A ramp run: 2^size steps from v to the speed there, of the first ramp
    /// (rise or ease) or of the fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn ramp(
        &mut self,
        clock: &Clock,
        work: &mut Work,
        run: &mut Run,
        first: bool,
    ) -> Planned {
        let up = first && !self.ease;
        let room = if first { self.rise } else { self.fall };
        if work.stage == Stage::Begin {
            // What is too long already is not even tried.
            let longest = hand(&clock.longest).roughly(&self.v).scaled(1).number();
            while self.size > 0 && !hand(&longest).scaled(-(self.size as i8)).at_least(&clock.twice)
            {
                self.size -= 1;
            }
        }
        let size = self.size.min(clock.ramp_size);
        let full = 1u32 << size;
        let steps = share_of_ramp(room, full);
        match work.stage {
            _ if self.is_bent() => {
                if !self.follow(clock, work, steps, first) {
                    return Planned::Again;
                }
                work.stage = Stage::Begin;
            }
            Stage::Begin => {
                self.speed_after(steps, first).to(&mut work.pending);
                work.stage = Stage::Half;
                return Planned::Again;
            }
            Stage::Half => {
                let change = hand(&work.pending);
                let change = if up { change.minus(&self.v) } else { change.off(&self.v) };
                change.to(&mut work.delta);
                let mean = hand(&work.pending).plus(&self.v).under(&clock.twice);
                // δ and what follows from it need few bits: the run's end is
                // exact.
                let delta = mean.also(&mut work.mean).roughly(&clock.inverse).roughly(&work.delta);
                delta.scaled(1).to(&mut work.delta);
                work.stage = Stage::Late;
                return Planned::Again;
            }
            Stage::Late | Stage::Last => work.stage = Stage::Begin,
        }
        let bent = self.is_bent().then(|| self.jerk_of(clock, work, size));
        let (mean, delta) = (&work.mean, &work.delta);
        let mut spread = hand(delta).roughly(delta);
        if let Some(jerk) = &bent {
            spread = spread.plus(jerk);
        }
        let error = spread.roughly(mean).scaled(size as i8 - 5).number();
        if size > 0
            && !(clock.holds(mean, size)
                && error.is_below(clock.bound.into())
                && delta.is_below(-2))
        {
            self.size = size - 1;
            return Planned::Again;
        }
        // Twice the length has eight times the error; a fall's grows by itself.
        // A run that was short for want of room says nothing of the next ones.
        if steps == full {
            self.size = if clock.holds(mean, size + 1)
                && error.is_below((clock.bound - if up { 3 } else { 4 }).into())
                && delta.is_below(-4)
            {
                size + 1
            } else if !up && size > 0 && !error.is_below((clock.bound - 1).into()) {
                size - 1
            } else {
                size
            };
        }
        if first {
            self.rise = self.rise.wrapping_sub(steps);
            self.risen = self.risen.wrapping_add(steps);
        } else {
            self.fall = self.fall.wrapping_sub(steps);
        }
        self.v = work.pending;
        self.bent.goes_to(work.time);
        // An even number: then neither a stride's mean interval nor the spread
        // has a half to lose.
        let mut half = hand(delta).roughly(mean).scaled(15 - size as i8);
        if steps != full {
            let sum = half.scaled(size as i8).number();
            half = whole(steps).under(&sum);
        }
        let add = (half.rounded_whole() as i32).wrapping_shl(1);
        self.fitted(run, mean, if up { add.wrapping_neg() } else { add }, steps as u16)
    }

    /// The speed so many steps further on the first ramp or down the fall.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn speed_after(&self, steps: u32, first: bool) -> Hand {
        let (slope, w, n) = match (first, self.ease) {
            (true, false) => (&self.a2, &self.w_from, self.risen.wrapping_add(steps)),
            // What falls is reckoned from its end: nothing is subtracted.
            (true, true) => (&self.slope, &self.w_from, self.rise.wrapping_sub(steps)),
            _ => (&self.d2, &self.w_end, self.fall.wrapping_sub(steps)),
        };
        whole(n).times(slope).plus(w).root()
    }

    /// So many steps with this mean interval, growing by `add`, an even number.
    ///
    /// ```text
    ///   first interval = mean − add·(N − 1)/2
    /// ```
    ///
    /// rounded down, in 2⁻¹⁶ ticks; what the N of them lack then is carried.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn fitted(&mut self, run: &mut Run, mean: &Num, add: i32, steps: u16) -> Planned {
        let (whole, part) = mean.split();
        let wide = u32::from(steps);
        // Both are less than the steps of a run, 2¹⁵ at most, in 2⁻¹⁶ ticks: no
        // overflow.
        let lack = u32::from(part as u16).wrapping_mul(wide);
        let carry = self.carry.wrapping_add(lack);
        let more = ((carry >> 16) as u16).checked_div(steps).unwrap_or(0);
        self.carry = carry.wrapping_sub(u32::from(more.wrapping_mul(steps)) << 16);
        // It is less than δ of the interval, and fits: see `holds`.
        let spread = (add >> 1).wrapping_mul(wide.wrapping_sub(1) as i32);
        let first = u64::from(whole) << 16 | u64::from(part >> 16);
        let shift = i32::from(more).wrapping_sub(spread);
        *run = Run::new(first.wrapping_add_signed(shift.into()), add, steps);
        Planned::Run(whole.wrapping_mul(wide))
    }

    /// A level run.
    pub(super) fn cruise(&mut self, clock: &Clock, work: &mut Work, run: &mut Run) -> Planned {
        if work.stage == Stage::Begin {
            let v = hand(&self.v_top).also(&mut self.v);
            v.under(&clock.twice).scaled(-1).to(&mut work.mean);
            work.stage = Stage::Half;
            return Planned::Again;
        }
        work.stage = Stage::Begin;
        let room = self.level.wrapping_sub(u32::from(self.fall_part != 0 && !self.endless));
        let mut size = clock.level_size;
        while size > 0 && !clock.holds(&work.mean, size) {
            size -= 1;
        }
        let steps = share(room, 1 << size);
        if !self.endless {
            self.level = self.level.wrapping_sub(steps);
        }
        self.fitted(run, &work.mean, 0, steps as u16)
    }

    /// The one step that a change of piece divides.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(super) fn corner(
        &mut self,
        clock: &Clock,
        work: &mut Work,
        run: &mut Run,
        last: bool,
    ) -> Planned {
        if self.is_bent() {
            return self.bent_corner(clock, work, run, last);
        }
        let rise = self.rise_part;
        let fall = if last { self.fall_part } else { 0 };
        match work.stage {
            Stage::Begin => {
                hand(&self.v).plus(&self.v_top).to(&mut work.mean);
                part(rise).times(&clock.twice).over(&work.mean).to(&mut work.pending);
                work.stage = Stage::Half;
                Planned::Again
            }
            Stage::Half => {
                part(fall).to(&mut work.mean);
                part(rise).to(&mut work.delta);
                whole(1).minus(&work.delta).minus(&work.mean).to(&mut work.mean);
                let level = hand(&self.v_top).under(&clock.twice).scaled(-1).times(&work.mean);
                level.plus(&work.pending).to(&mut work.pending);
                work.stage = Stage::Late;
                Planned::Again
            }
            Stage::Late if last => {
                self.speed_after(0, false).to(&mut work.mean);
                work.stage = Stage::Last;
                Planned::Again
            }
            Stage::Late | Stage::Last => {
                self.v = self.v_top;
                if last {
                    self.v = work.mean;
                    hand(&self.v_top).plus(&self.v).to(&mut work.mean);
                    let time = part(fall).times(&clock.twice).over(&work.mean);
                    time.plus(&work.pending).to(&mut work.pending);
                    self.fall_part = 0;
                }
                self.rise_part = 0;
                if !self.endless {
                    self.level = self.level.wrapping_sub(1);
                }
                work.stage = Stage::Begin;
                self.fitted(run, &work.pending, 0, 1)
            }
        }
    }
}
