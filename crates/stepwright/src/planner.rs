//! The planner of one axis: runs from the closed form, on a small chip.
//!
//! A travel consists of whole steps of rise, level and fall, and up to two *corner* steps, within
//! which one piece changes to the next:
//!
//! ```text
//!   w = v²            rise     corner     level     corner     fall
//!   w_top                ┌──────────────────────────────┐
//!                       ╱ part of a step     part of a step ╲      w = w_end + d2·(left)
//!   w_from             ╱                                     ╲     w = w_from + a2·n
//! ```
//!
//! It can be set up again from any pulse, at the speed v there, with L steps to go and other limits
//! (`change.rs`). Above the new top speed the rise is an *ease*: a fall to that speed. If there is
//! no room for it, a single fall leads to rest. If the top speed is out of reach, the highest speed
//! that leaves room for rise and fall follows from the steps (Austin, Eq 19), or for bent ramps
//! from Newton's method (`divide.rs`). A target nearer than the braking distance can't be reached:
//! then the axis brakes to rest.
//!
//! With a jerk limit the ramps are bent ([`Curve`]), otherwise straight; `ramp.rs` finds the ends
//! of the runs of either.
//!
//! At constant acceleration the time between two pulses depends on their mean speed alone, so no
//! large numbers are subtracted:
//!
//! ```text
//!   Δt = 2·N / (v₁ + v₂)                 N steps from v₁ to v₂
//!   add = Δt/N · δ/N                     δ = 2·(v₂ − v₁)/(v₁ + v₂) = 2·N·slope/(v₁ + v₂)²
//!   error of the N − 1 steps between ≤ Δt·δ²/42
//! ```
//!
//! (add is t″ at the mean speed; the parabola leaves out at most t‴·N³/125, with t‴ = 3·Δt·δ²/N³.
//! While δ ≤ ¼ the next term adds less than a tenth, which 42 → 32 covers.) Lengths are powers of
//! two, except for the last two of a ramp.
//!
//! **Error.** For straight ramps each Δt has a relative error of 2⁻²⁹. So the pulse at the end of
//! each run is within 2⁻²⁹ of the travel's time, 2 ns in a second; the pulses between within the
//! [`Fit`](crate::profile::Fit) as well. The rest of the rounding to 2⁻¹⁶ ticks is added to the
//! next run. A fall that a stop begins leaves out 2⁻²⁸ of v²: it comes earlier by 2⁻²⁹ of the time
//! that it takes from v to rest. [`Path`](crate::profile::Path) has an error of 2⁻⁴⁰, at ten times
//! the cost and size: it is for hosts.
//!
//! **Cost** on an ATmega328P, measured in simavr: a run of a straight ramp takes a root, a division
//! and seven products, in four calls, the last of which queues it. The longest call takes 3,080
//! cycles, including the slave's way to it (`planning_burst`); for a bent ramp 10,082, in a
//! controller that had them.

mod bent;
mod change;
mod clock;
mod curve;
mod divide;
mod layout;
mod load;
mod ramp;
mod runs;
mod share;
mod work;

use crate::clamp;
use crate::num::{Hand, Num, hand, whole};
use crate::order::Change;
use crate::profile::Unfit;
use crate::units::Ticks;
use bent::Bent;
pub(crate) use clock::Clock;
use curve::Curve;
pub(crate) use layout::Layout;
pub(crate) use load::Load;
use work::Stage;
pub(crate) use work::{Planned, Work};

/// Plans the runs of one travel, one at a time.
///
/// The order of the fields is for an AVR, which reaches 63 bytes from a pointer with one
/// instruction: numbers, of which only the address is needed, come last.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Planner {
    endless: bool,
    /// Whether the rise is an ease, a fall to the top speed.
    ease: bool,
    /// The run length to try next, as a power of two.
    size: u8,
    /// Whether the ramps have no jerk limit.
    straight: bool,
    /// If the rest must be set up again once the level is reached: the piece to do then.
    /// [`Layout::Nothing`] if the ramp in progress is the fall.
    piece: Layout,
    /// How many more top speeds may be tried.
    tries: u8,
    /// The time that the runs handed out lack, in 2⁻³² ticks.
    carry: u32,
    /// Steps of the rise that were handed out.
    risen: u32,
    /// Whole steps left of the rise, the level (with its corners) and the fall.
    rise: u32,
    level: u32,
    fall: u32,
    /// Fractions of a step, in 2⁻³²: of the rise in the first corner, of the fall in the last.
    rise_part: u32,
    fall_part: u32,
    /// The speed at the last pulse handed out, the highest allowed speed, and the speed between
    /// rise and fall.
    v: Num,
    top: Num,
    v_top: Num,
    /// Speed² at the low end of a straight ramp; while rise and fall are being divided, the lower
    /// bound of the speed between them.
    w_from: Num,
    /// While bent ramps are being divided, the upper bound of the speed between them.
    most: Bent,
    /// The speed at the very last pulse.
    v_end: Num,
    /// The slopes of the rise and the fall: 2a and 2d; and of an ease, at most 2d. Before there is
    /// an ease, the last is also the place of an interval.
    a2: Num,
    d2: Num,
    slope: Num,
    /// The time from the low end of the ramp to the last pulse handed out, if the ramp is bent.
    at: Num,
    /// The ramp in progress.
    curve: Curve,
}

/// Converts an acceleration in 0.001 steps/s² to its slope: 2a in 10⁻⁶ (steps/s)² per step.
#[cfg_attr(not(target_pointer_width = "64"), inline(never))]
fn twice(a: &mut Num) {
    whole(2000).times(a).to(a);
}

impl Planner {
    /// Nothing to do. All zeros, so that it takes no flash.
    pub(crate) const IDLE: Planner = Planner {
        w_from: Num::UNSET,
        most: Bent::UNSET,
        v_end: Num::UNSET,
        a2: Num::UNSET,
        d2: Num::UNSET,
        slope: Num::UNSET,
        v: Num::UNSET,
        top: Num::UNSET,
        v_top: Num::UNSET,
        risen: 0,
        rise: 0,
        level: 0,
        fall: 0,
        rise_part: 0,
        fall_part: 0,
        at: Num::UNSET,
        curve: Curve::NONE,
        straight: false,
        piece: Layout::Speeds,
        tries: 0,
        endless: false,
        ease: false,
        carry: 0,
        size: 0,
    };

    /// Sets up another travel from rest, with the limits of the last one and this many pulses, the
    /// first of which is not part of the runs.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn lay_out_again(&mut self, pulses: u32) {
        self.begin_again();
        self.divide(clamp::less(pulses, 1));
    }

    /// Reduces the rest to its limits, for the computation of its [`load`](Planner::load), which is
    /// then that of its top speed. `left` steps to the target, less than 0 if it is behind.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn outline(&mut self, left: i32) {
        let left = if self.endless { i32::MAX } else { left.max(0) } as u32;
        self.fall = load::RAMPS;
        self.level = clamp::less(left, load::RAMPS);
        self.piece = Layout::Rise;
    }

    /// Goes back to the beginning of a travel.
    fn begin_again(&mut self) {
        self.carry = 0;
        self.v.set(&self.v_end);
    }

    /// Sets another limit from now on: [`check`](Planner::check) whether it can be kept, then
    /// [`resume`](Planner::resume) applies it.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn limit(&mut self, change: &Change) {
        match change {
            // The ramps do not get steeper, and need no longer end without a target.
            Change::Target(_) => self.endless = false,
            Change::Accel(a) | Change::Decel(a) => {
                let up = matches!(change, Change::Accel(_));
                let slope = if up { &mut self.a2 } else { &mut self.d2 };
                slope.set_wide(a.millisteps());
                twice(slope);
            }
            Change::Top(top) => whole(top.millisteps()).to(&mut self.top),
        }
    }

    /// Checks that no interval exceeds 2³² ticks, including the one across the peak, and that there
    /// are ramps if a speed must be gained or lost. On an endless travel, where no target bounds
    /// them, the ramps take less than 2³¹ steps; those of a curve less than 2²².
    ///
    /// # Errors
    /// [`Unfit::BelowStart`], [`Unfit::TooGentle`], or another if the timer can't represent it.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn check(&mut self, clock: &Clock) -> Result<(), Unfit> {
        if !self.top.at_least(&self.v_end) {
            return Err(Unfit::BelowStart);
        }
        // Three intervals of less than 2³⁰ ticks need no sum, which takes a chip 4,000 cycles.
        let least = hand(&clock.twice).scaled(-30).number();
        let rests = self.v_end.is_zero();
        let slowest = if rests { &self.top } else { &self.v_end };
        let long = least.at_least(slowest)
            || rests && hand(&least).square().at_least(self.gentle())
            || !self.is_straight();
        if !long {
            return self.check_ramps();
        }
        let mut piece = Layout::First;
        while piece != Layout::Rise {
            piece = self.check_piece(clock, piece)?;
        }
        Ok(())
    }

    /// The lower of both slopes.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn gentle(&self) -> &Num {
        if self.a2.at_least(&self.d2) { &self.d2 } else { &self.a2 }
    }

    /// Does a piece of the check, and returns the next piece.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn check_piece(&mut self, clock: &Clock, piece: Layout) -> Result<Layout, Unfit> {
        // From rest: the first step takes √(2/a), the last √(2/d).
        let rests = self.v_end.is_zero();
        match piece {
            Layout::First => {
                self.first(clock).to(&mut self.slope);
                return Ok(Layout::Last);
            }
            Layout::Last => {
                if rests {
                    let last = hand(&self.d2).root().under(&clock.twice).plus(&self.slope);
                    last.to(&mut self.slope);
                }
                return Ok(Layout::Limits);
            }
            _ => {}
        }
        if rests {
            clock.interval(&self.top).plus(&self.slope).to(&mut self.slope);
        }
        if !hand(&self.slope).below(32) || rests && !self.is_straight() && !self.can_start(clock) {
            return Err(Unfit::TooSlow);
        }
        self.check_ramps()?;
        Ok(Layout::Rise)
    }

    /// The part of the check for the ramps.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn check_ramps(&self) -> Result<(), Unfit> {
        let high = if self.top.at_least(&self.v) { &self.top } else { &self.v };
        if self.v_end.at_least(high) {
            return Ok(());
        }
        let gentle = self.gentle();
        // The target bounds the ramps, if there are any: but not a stop.
        let (fast, bits) = if !self.is_straight() {
            (high, 21)
        } else if self.endless {
            (high, 31)
        } else {
            (&self.v, 30)
        };
        let w = hand(fast).square().number();
        let ends = !gentle.is_zero()
            && !hand(&w).scaled(-bits).at_least(gentle)
            && (self.is_straight() || self.ends(high, &w));
        if ends { Ok(()) } else { Err(Unfit::TooGentle) }
    }

    /// The highest speed from here on, in 0.001 steps/s, rounded up; 1 if nothing is left to plan,
    /// because the queued steps still move.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn peak(&self) -> u32 {
        if self.steps_left() == 0 {
            return Load::QUEUED.peak;
        }
        let top = if self.is_again() { &self.top } else { &self.v_top };
        let peak = if top.at_least(&self.v) { top } else { &self.v };
        let (whole, part) = peak.split();
        clamp::sum(whole, (part != 0).into())
    }

    /// The number of steps left; `u32::MAX` on an endless travel.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn steps_left(&self) -> u32 {
        if self.endless {
            u32::MAX
        } else {
            self.rise.wrapping_add(self.level).wrapping_add(self.fall)
        }
    }

    /// How long the axis rests after the travel, in ticks: an interval of the start speed; from
    /// rest √(2/a), the first interval of a ramp, or an interval of the top speed if that is
    /// longer. So two travels of a single step are no closer than the first two steps of a longer
    /// travel may be. Computed with the limits of the last travel that was planned, or refused:
    /// call it at the end of the travel.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn rest(&self, clock: &Clock) -> Ticks {
        if !self.v_end.is_zero() {
            return self.first(clock).split().0;
        }
        // Both are `twice` divided by a speed: one division, by the slower of them.
        let (mut slower, top) = (hand(&self.a2).root().number(), self.top.scaled(1));
        if slower.at_least(&top) {
            slower.set(&top);
        }
        hand(&clock.twice).over(&slower).split().0
    }

    /// The interval of the start speed; from rest √(2/a).
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn first(&self, clock: &Clock) -> Hand {
        if self.v_end.is_zero() {
            hand(&self.a2).root().under(&clock.twice)
        } else {
            clock.interval(&self.v_end)
        }
    }

    /// Whether the travel has no end.
    pub(crate) fn is_endless(&self) -> bool {
        self.endless
    }

    /// Plans the next run, one piece per call.
    pub(crate) fn next(&mut self, clock: &Clock, work: &mut Work) -> Planned {
        if self.rise > 0 {
            self.ramp(clock, work, true)
        } else if self.is_again() && self.rise_part == 0 {
            self.divide_again();
            Planned::Again
        } else if self.level > 0 {
            self.level(clock, work)
        } else if self.fall > 0 {
            self.ramp(clock, work, false)
        } else {
            Planned::End
        }
    }
}

#[cfg(test)]
mod tests;
