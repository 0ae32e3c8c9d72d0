//! The planner of one axis: runs from the closed form, on a small chip.
//!
//! A travel is whole steps of rise, level and fall, and up to two *corner*
//! steps that a change of piece divides:
//!
//! ```text
//!   w = v²            rise     corner     level     corner     fall
//!   w_top                ┌──────────────────────────────┐
//!                       ╱ part of a step     part of a step ╲      w = w_end + d2·(left)
//!   w_from             ╱                                     ╲     w = w_from + a2·n
//! ```
//!
//! It can be set up again from any pulse, at the speed v there, with L steps to
//! go and other limits (`change.rs`). Above the new top speed the rise is an *ease*: a fall to
//! it. Where it has no room, one fall leads to rest. Where the top speed is out of reach, the
//! highest that rise and fall leave room for follows from the steps (Austin, Eq 19), or where they
//! are bent from Newton's method (`divide.rs`). A target
//! nearer than the way to rest can't be reached: then it brakes to rest.
//!
//! With a limit of jerk the ramps are bent ([`Curve`]), without one straight; where a run of
//! either ends, `ramp.rs` says.
//!
//! Constant acceleration makes the time between two pulses a matter of their
//! mean speed alone, with no difference of large numbers in it:
//!
//! ```text
//!   Δt = 2·N / (v₁ + v₂)                 N steps from v₁ to v₂
//!   add = Δt/N · δ/N                     δ = 2·(v₂ − v₁)/(v₁ + v₂) = 2·N·slope/(v₁ + v₂)²
//!   error of the N − 1 steps between ≤ Δt·δ²/42
//! ```
//!
//! (add is t″ at the mean speed; what a parabola leaves out is t‴·N³/125 at
//! most, and t‴ = 3·Δt·δ²/N³. While δ ≤ ¼ the next term adds less than a
//! tenth, which 42 → 32 covers.) Lengths are powers of two, but for the last two of a ramp.
//!
//! **Error.** Of straight ramps each Δt is good to 2⁻²⁹ of itself, so the pulse at the end of
//! each run comes within 2⁻²⁹ of the travel's time of where it belongs, 2 ns
//! in a second; those between within the [`Fit`](crate::profile::Fit) as well. What rounding to
//! 2⁻¹⁶ ticks leaves over goes to the next run.
//! A fall that a stop begins leaves out a part in 2²⁸ of v²: it comes earlier by 2⁻²⁹ of the time
//! that it takes from v to rest.
//! [`Path`](crate::profile::Path) says the same to 2⁻⁴⁰, at ten times the
//! cost and size: it is for hosts.
//!
//! **Cost** on an ATmega328P, measured in simavr: a run of a straight ramp takes a root, a division
//! and seven products, in four calls, the last of which queues it. The longest call takes 3,080
//! cycles, the slave's way to it included (`planning_burst`); of a bent ramp 10,082, in a
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
/// The order of the fields is for an AVR, which reaches 63 bytes from a pointer
/// with one instruction: numbers, of which only the address is needed, come last.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Planner {
    endless: bool,
    /// The rise is an ease: it falls, to the top speed.
    ease: bool,
    /// Run length to try next, as a power of two.
    size: u8,
    /// Its ramps have no limit of jerk.
    straight: bool,
    /// Where the rest is to be set up again once the level is reached: the piece to do then.
    /// [`Layout::Nothing`] if the ramp in progress is the fall.
    piece: Layout,
    /// How many top speeds may still be tried.
    tries: u8,
    /// What the runs handed out lack, in 2⁻³² ticks.
    carry: u32,
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
    /// Speed at the last pulse handed out, the highest allowed, and that
    /// between rise and fall.
    v: Num,
    top: Num,
    v_top: Num,
    /// Speed² at the low end of a straight ramp; while rise and fall are sought, the least speed
    /// between them.
    w_from: Num,
    /// While bent ones are sought, the highest speed between them.
    most: Bent,
    /// Speed at the last pulse of all.
    v_end: Num,
    /// Slopes of the rise and the fall: 2a and 2d; and of an ease, at most 2d. The last is
    /// also the place of an interval, before there is an ease.
    a2: Num,
    d2: Num,
    slope: Num,
    /// The time from the ramp's low end to the last pulse handed out, if it is bent.
    at: Num,
    /// The ramp in progress.
    curve: Curve,
}

/// An acceleration in 0.001 steps/s² becomes its slope: 2a in 10⁻⁶ (steps/s)² per step.
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

    /// Sets up another travel from rest, within the limits of the last: so
    /// many pulses, the first of which is not part of the runs.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn lay_out_again(&mut self, pulses: u32) {
        self.begin_again();
        self.divide(clamp::less(pulses, 1));
    }

    /// Of what is left only the limits count: for who asks for its [`load`](Planner::load), which is
    /// that of its top speed then.
    #[inline(always)]
    pub(crate) fn outline(&mut self) {
        (self.rise, self.level, self.fall) = (0, 1, 0);
        self.piece = Layout::Rise;
    }

    /// Goes back to the beginning of a travel.
    fn begin_again(&mut self) {
        self.carry = 0;
        self.v.set(&self.v_end);
    }

    /// Has another limit from now on: [`resume`](Planner::resume) keeps to it.
    ///
    /// # Errors
    /// [`Unfit::BelowStart`], [`Unfit::TooGentle`], or another if the timer can't hold what
    /// comes of it.
    pub(crate) fn limit(&mut self, clock: &Clock, change: &Change) -> Result<(), Unfit> {
        match change {
            Change::Target(_) => {
                // Its ramps are no steeper for it, and need no longer end by themselves.
                self.endless = false;
                return Ok(());
            }
            Change::Accel(a) | Change::Decel(a) => {
                let up = matches!(change, Change::Accel(_));
                let slope = if up { &mut self.a2 } else { &mut self.d2 };
                *slope = Num::from_wide(a.millisteps());
                twice(slope);
            }
            Change::Top(top) => {
                whole(top.millisteps()).to(&mut self.top);
                if self.top.is_zero() || !self.top.at_least(&self.v_end) {
                    return Err(Unfit::BelowStart);
                }
            }
        }
        self.check(clock)
    }

    /// No interval may exceed 2³² ticks, the one across the peak included. And where there
    /// is a speed to gain and to lose there must be ramps. On an endless travel, where no
    /// target bounds them, they take less than 2³¹ steps; a curve's less than 2²².
    fn check(&mut self, clock: &Clock) -> Result<(), Unfit> {
        let mut piece = Layout::First;
        while piece != Layout::Rise {
            piece = self.check_piece(clock, piece)?;
        }
        Ok(())
    }

    /// Does a piece of that, and tells the next.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn check_piece(&mut self, clock: &Clock, piece: Layout) -> Result<Layout, Unfit> {
        // From rest: the first step alone takes √(2/a), the last √(2/d).
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
        let high = if self.top.at_least(&self.v) { &self.top } else { &self.v };
        if self.v_end.at_least(high) {
            return Ok(Layout::Rise);
        }
        let gentle = if self.a2.at_least(&self.d2) { &self.d2 } else { &self.a2 };
        let w = hand(high).square().number();
        // Its target bounds its ramps, if there are any.
        let bits = if !self.is_straight() {
            21
        } else if self.endless {
            31
        } else {
            127
        };
        let ends = hand(&w).over(gentle).below(bits) && (self.is_straight() || self.ends(high, &w));
        if ends { Ok(Layout::Rise) } else { Err(Unfit::TooGentle) }
    }

    /// The highest speed from here on, in 0.001 steps/s, rounded up; 1 if nothing is left to plan,
    /// for what is queued moves.
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

    /// Steps that are still to be handed out; `u32::MAX` on an endless travel.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn steps_left(&self) -> u32 {
        if self.endless {
            u32::MAX
        } else {
            self.rise.wrapping_add(self.level).wrapping_add(self.fall)
        }
    }

    /// How long the axis rests after the travel, in ticks: an interval of the start speed;
    /// from rest √(2/a), the first interval of a ramp, or one of the top speed, if that is
    /// longer. Two travels of a step each come no closer than the first two steps of a longer
    /// one may. By the limits of the last travel that was planned, or refused: to be asked at
    /// its end.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn rest(&self, clock: &Clock) -> Ticks {
        if !self.v_end.is_zero() {
            return self.first(clock).split().0;
        }
        // Both are `twice` over a speed: one division for the slower of them.
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

    /// Whether it goes on until it is stopped.
    pub(crate) fn is_endless(&self) -> bool {
        self.endless
    }

    /// Plans the next run, a piece of it a call.
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
