//! The planner of one axis: runs from the closed form, on a small chip.
//!
//! A travel is whole steps of rise, level and fall, and up to two *corner*
//! steps that a change of piece divides:
//!
//! ```text
//!   w = v²            rise     corner     level     corner     fall
//!   w_top                ┌──────────────────────────────┐
//!                       ╱ part of a step     part of a step ╲      w = w_from + a2·n
//!   w_from, w_end      ╱                                     ╲     w = w_end + d2·(left)
//! ```
//!
//! Constant acceleration makes the time between two pulses a matter of their
//! mean speed alone, with no difference of large numbers in it:
//!
//! ```text
//!   Δt = 2·N / (v₁ + v₂)                 N steps from v₁ to v₂
//!   add = Δt/N · δ/N                     δ = 2·(v₂ − v₁)/(v₁ + v₂)
//!   error of the N − 1 steps between ≤ Δt·δ²/42
//! ```
//!
//! (add is t″ at the mean speed; what a parabola leaves out is t‴·N³/125 at
//! most, and t‴ = 3·Δt·δ²/N³. While δ ≤ ¼ the next term adds less than a
//! tenth, which 42 → 32 covers.) Lengths are powers of two.
//!
//! **Error.** Each Δt is good to 2⁻²⁹ of itself, so the pulse at the end of
//! each run comes within 2⁻²⁹ of the travel's time of where it belongs, 2 ns
//! in a second; those between within the [`Fit`] as well. What rounding to
//! 2⁻¹⁶ ticks leaves over goes to the next run.
//! [`Path`](crate::profile::Path) says the same to 2⁻⁴⁰, at ten times the
//! cost and size: it is for hosts.
//!
//! **Cost** on an ATmega328P: a run takes a root, a division and six products.

use crate::num::Num;
use crate::order::{Order, Travel};
use crate::profile::{Fit, Ramp, Unfit};
use crate::run::Run;
use crate::units::{Accel, Rate, Speed, Ticks};

/// What all axes share: the timer's rate and how closely to follow a law, as
/// the formulas want them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    /// 2f, in ticks · 0.001 steps/s.
    twice: Num,
    /// Its inverse.
    inverse: Num,
    /// Largest error of a step between two ends of runs, in ticks.
    bound: Num,
    /// Longest run, in ticks; a single step may always take longer.
    longest: Num,
    /// Longest ramp run and longest level run, as powers of two.
    ramp_size: u8,
    level_size: u8,
}

impl Clock {
    pub(crate) fn new(rate: Rate, fit: &Fit) -> Clock {
        // 2000 · rate: twice the rate, and a speed is in thousandths.
        let twice = Num::from(rate.hz()).times(&Num::from(2000));
        Clock {
            twice,
            inverse: Num::ONE.over(&twice),
            bound: Num::from_wide(fit.error).scaled(-32),
            longest: Num::from(fit.longest),
            ramp_size: fit.ramp_size,
            level_size: fit.level_size,
        }
    }

    /// The interval at a speed; beyond everything for 0.
    fn interval(&self, v: Num) -> Num {
        self.twice.over(&v).scaled(-1)
    }
}

/// Plans the runs of one travel, one at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Planner {
    /// Speed² at the first pulse and at the last.
    w_from: Num,
    w_end: Num,
    /// Slopes of the rise and the fall: 2a and 2d.
    a2: Num,
    d2: Num,
    /// Speed at the last pulse handed out, and between rise and fall.
    v: Num,
    v_top: Num,
    /// Steps of the rise handed out.
    risen: u32,
    /// Whole steps left of rise, level (with its corners) and fall.
    rise: u32,
    level: u32,
    fall: u32,
    /// Parts of a step, in 2⁻³²: of the rise in the first corner, of the fall
    /// in the last.
    rise_part: u32,
    fall_part: u32,
    endless: bool,
    /// What the runs handed out lack, in 2⁻¹⁶ ticks.
    carry: u16,
    /// Run length to try next, as a power of two.
    size: u8,
}

/// What [`Planner::next`] has done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Planned {
    /// Play this; it lasts for so many ticks.
    Run(Run, Ticks),
    /// A run that was too long was thrown away: ask again.
    Again,
    /// The travel is planned to its end.
    End,
}

/// Half a tick ahead, so that deadlines rounded down are rounded to nearest.
const HALF_TICK: u16 = 1 << 15;

/// Speed² of a speed, in 10⁻⁶ (steps/s)².
fn square(v: Speed) -> Num {
    let v = Num::from(v.millisteps());
    v.times(&v)
}

/// 2a in 10⁻⁶ (steps/s)² per step.
fn slope(order: &Order, ramp: Ramp) -> Result<Num, Unfit> {
    let least = Accel::MIN.millisteps();
    let of = |a: u64| Num::from_wide(a).times(&Num::from(2000));
    match ramp {
        Ramp::Steps(0) => Err(Unfit::NoRamp),
        Ramp::Steps(steps) => {
            let rise = square(order.top).minus(&square(order.start));
            // To the nearest 10⁻⁶, as the law holds it.
            let slope = rise.over(&Num::from(u32::from(steps))).rounded();
            let least = of(least);
            Ok(if slope.at_least(&least) { slope } else { least })
        }
        Ramp::Accel(a) => Ok(of(a.millisteps())),
    }
}

impl Planner {
    /// From rest to rest, or on and on. The first pulse, at time 0, is not
    /// part of the runs.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn new(clock: &Clock, order: &Order) -> Result<Planner, Unfit> {
        let pulses = match order.travel {
            Travel::By(steps) => steps.unsigned_abs(),
            Travel::Endless(_) => u32::MAX,
        };
        let (a2, d2) = (slope(order, order.up)?, slope(order, order.down)?);
        if order.top == Speed::ZERO {
            return Err(Unfit::Standstill);
        }
        let v_top = Num::from(order.top.millisteps());
        let v = Num::from(order.start.min(order.top).millisteps());
        let w = v.times(&v);
        let mut planner = Planner {
            w_from: w,
            w_end: w,
            a2,
            d2,
            v,
            v_top,
            risen: 0,
            rise: 0,
            level: 0,
            fall: 0,
            rise_part: 0,
            fall_part: 0,
            endless: matches!(order.travel, Travel::Endless(_)),
            carry: HALF_TICK,
            size: 0,
        };
        planner.check(clock)?;
        planner.lay_out(pulses.saturating_sub(1));
        Ok(planner)
    }

    /// No interval may exceed 2³¹ ticks, the one across the peak included.
    fn check(&self, clock: &Clock) -> Result<(), Unfit> {
        let slowest = if self.v.is_zero() {
            // From rest: the first step alone takes √(2/a), the last √(2/d).
            let first = clock.twice.over(&self.a2.root());
            let last = clock.twice.over(&self.d2.root());
            first.plus(&last).plus(&clock.interval(self.v_top))
        } else {
            clock.interval(self.v)
        };
        if slowest.at_least(&Num::from(1 << 31)) { Err(Unfit::TooSlow) } else { Ok(()) }
    }

    /// Divides `steps` into rise, level and fall.
    fn lay_out(&mut self, steps: u32) {
        let w_top = self.v_top.times(&self.v_top);
        let rise = w_top.minus(&self.w_from).over(&self.a2);
        if self.endless {
            (self.rise, self.rise_part) = rise.split();
            self.level = u32::MAX;
            return;
        }
        let fall = w_top.minus(&self.w_end).over(&self.d2);
        let length = Num::from(steps);
        if !length.at_least(&rise.plus(&fall)) {
            // The top speed is out of reach: the rise meets the fall at
            // d2·L / (a2 + d2) (document 002, Eq 19).
            let rise = length.times(&self.d2.over(&self.a2.plus(&self.d2)));
            let w = self.w_from.plus(&self.a2.times(&rise));
            self.v_top = w.root();
            (self.rise, self.rise_part) = rise.split();
            self.rise = self.rise.min(steps);
            if self.rise == steps {
                self.rise_part = 0;
            }
            let left = steps.wrapping_sub(self.rise);
            if self.rise_part == 0 {
                self.fall = left;
            } else {
                (self.level, self.fall) = (1, left.wrapping_sub(1));
                self.fall_part = 0u32.wrapping_sub(self.rise_part);
            }
            return;
        }
        (self.rise, self.rise_part) = rise.split();
        (self.fall, self.fall_part) = fall.split();
        self.level = steps.saturating_sub(self.rise).saturating_sub(self.fall);
    }

    /// Brakes from the last pulse handed out, in as few steps as the ramp
    /// allows: on at the same speed for the part of a step that is left over,
    /// then the fall.
    pub(crate) fn brake(&mut self) {
        if self.rise == 0 && self.level == 0 {
            return; // braking already
        }
        let w = self.v.times(&self.v);
        let (whole, part) = w.minus(&self.w_end).over(&self.d2).split();
        let steps = if part == 0 { whole } else { whole.saturating_add(1) };
        if !self.endless && steps >= self.steps_left() {
            return; // the travel's own end is as near
        }
        (self.rise, self.rise_part) = (0, 0);
        (self.level, self.fall) = (steps.wrapping_sub(whole), whole);
        self.fall_part = part;
        self.v_top = self.v;
        self.endless = false;
        self.size = 0;
    }

    /// The highest speed from here on, in 0.001 steps/s, rounded up; 0 if
    /// nothing is left.
    pub(crate) fn peak(&self) -> u32 {
        if self.steps_left() == 0 {
            return 0;
        }
        let (whole, part) = self.v_top.split();
        whole.saturating_add(u32::from(part != 0))
    }

    /// Steps that are still to be handed out; `u32::MAX` on an endless travel.
    pub(crate) fn steps_left(&self) -> u32 {
        if self.endless {
            u32::MAX
        } else {
            self.rise.saturating_add(self.level).saturating_add(self.fall)
        }
    }

    /// Whether it goes on until it is stopped.
    pub(crate) fn is_endless(&self) -> bool {
        self.endless
    }

    /// Plans the next run.
    pub(crate) fn next(&mut self, clock: &Clock) -> Planned {
        if self.rise > 0 {
            self.ramp(clock, true)
        } else if self.level > 0 {
            let last = self.level == 1 && self.fall_part != 0 && !self.endless;
            if self.rise_part != 0 || last {
                self.corner(clock, last)
            } else {
                self.cruise(clock)
            }
        } else if self.fall > 0 {
            self.ramp(clock, false)
        } else {
            Planned::End
        }
    }

    /// A ramp run: 2^size steps from v to the speed there.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn ramp(&mut self, clock: &Clock, up: bool) -> Planned {
        let room = if up { self.rise } else { self.fall };
        let mut size = self.size.min(clock.ramp_size);
        while room >> size == 0 {
            size -= 1; // room is not 0
        }
        let steps = 1u32 << size;
        let w = if up {
            self.w_from.plus(&self.a2.times(&Num::from(self.risen.wrapping_add(steps))))
        } else {
            self.w_end.plus(&self.d2.times(&Num::from(self.fall.wrapping_sub(steps))))
        };
        let v = w.root();
        let sum = self.v.plus(&v);
        let mean = clock.twice.over(&sum);
        // Changes of speed are of either sign: the larger less the smaller.
        let change = if up { v.minus(&self.v) } else { self.v.minus(&v) };
        let delta = mean.times(&clock.inverse).times(&change).scaled(1);
        let error = mean.scaled(size.into()).times(&delta.times(&delta)).scaled(-5);
        let long = mean.scaled(size.into()).at_least(&clock.longest);
        if size > 0 && (long || !clock.bound.at_least(&error) || delta.at_least(&QUARTER)) {
            self.size = size - 1;
            return Planned::Again;
        }
        // Twice the length has eight times the error; a fall's grows by itself.
        self.size = if clock.bound.at_least(&error.scaled(if up { 3 } else { 4 })) && !delta.at_least(&QUARTER.scaled(-2)) {
            size + 1
        } else if !up && !clock.bound.at_least(&error.scaled(1)) {
            size.saturating_sub(1)
        } else {
            size
        };
        let add = delta.times(&mean).scaled(0i16.wrapping_sub(size.into()));
        let planned = self.fitted(mean, add, size, up);
        if up {
            self.rise = self.rise.wrapping_sub(steps);
            self.risen = self.risen.wrapping_add(steps);
        } else {
            self.fall = self.fall.wrapping_sub(steps);
        }
        self.v = v;
        planned
    }

    /// 2^size steps with this mean interval, growing or shrinking by `add`.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn fitted(&mut self, mean: Num, add: Num, size: u8, up: bool) -> Planned {
        let total = mean.scaled(size.into()).fine().wrapping_add(self.carry.into());
        let span = (total >> 16) as Ticks;
        if size == 0 {
            self.carry = 0;
            return Planned::Run(Run::new(total, 0, 1), span);
        }
        let add = add.fine().min(i32::MAX as u64) as i64;
        let add = if up { -add } else { add };
        // The intervals differ from the first by add · N(N − 1)/2 in all.
        let triangle = (add << (2 * size - 1)).wrapping_sub(add << (size - 1));
        let rest = total.wrapping_add_signed(0i64.wrapping_sub(triangle));
        self.carry = rest as u16 & ((1u16 << size).wrapping_sub(1));
        Planned::Run(Run::new(rest >> size, add as i32, 1 << size), span)
    }

    /// A level run.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn cruise(&mut self, clock: &Clock) -> Planned {
        let room = self.level.wrapping_sub(u32::from(self.fall_part != 0 && !self.endless));
        let c = clock.interval(self.v_top);
        let mut size = clock.level_size;
                while size > 0 && (room >> size == 0 || c.scaled(size.into()).at_least(&clock.longest)) {
            size -= 1;
        }
        if !self.endless {
            self.level = self.level.wrapping_sub(1 << size);
        }
        self.v = self.v_top;
        self.fitted(c, Num::ZERO, size, false)
    }

    /// The one step that a change of piece divides.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn corner(&mut self, clock: &Clock, last: bool) -> Planned {
        let fall_part = if last { self.fall_part } else { 0 };
        let rise = Num::part(self.rise_part);
        let fall = Num::part(fall_part);
        let level = Num::ONE.minus(&rise).minus(&fall);
        let mut time = clock.twice.times(&rise).over(&self.v.plus(&self.v_top));
        time = time.plus(&clock.interval(self.v_top).times(&level));
        self.v = self.v_top;
        if last {
            let v = self.w_end.plus(&self.d2.times(&Num::from(self.fall))).root();
            time = time.plus(&clock.twice.times(&fall).over(&self.v_top.plus(&v)));
            self.v = v;
            self.fall_part = 0;
        }
        self.rise_part = 0;
        if !self.endless {
            self.level = self.level.wrapping_sub(1);
        }
        self.size = 0;
        self.fitted(time, Num::ZERO, 0, false)
    }
}

/// The largest relative change of speed in a run of more than one step.
const QUARTER: Num = Num::power(-2);
