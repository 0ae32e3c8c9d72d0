//! Pulses that stay high when the interrupt leaves.
//!
//! ```text
//!            visit      other events     visit
//!   STEP      ┌──────────────────────────┐
//!          ───┘       pulse              └───── pause ─► the next step at the earliest
//! ```

use super::track::State;
use super::{Engine, STEP};
use crate::drive::{Axes, Drive};
use crate::queue::Source;
use crate::timer::{Count, StepTimer};
use crate::units::Ticks;

/// The axes whose STEP is high, and the time at which each falls.
pub(super) struct Pulses<C, const N: usize> {
    high: Axes,
    falls: [C; N],
}

impl<C: Count, const N: usize> Pulses<C, N> {
    pub const NONE: Pulses<C, N> = Pulses { high: 0, falls: [C::ZERO.0; N] };

    /// Whether STEP of any axis is high.
    #[inline(always)]
    pub fn any(&self) -> bool {
        self.high != 0
    }

    /// Adds these axes, whose STEP falls at `fall`.
    #[inline(never)]
    pub fn add(&mut self, steps: Axes, fall: C) {
        self.high |= steps;
        for (axis, own) in self.falls.iter_mut().enumerate() {
            if steps >> axis & 1 != 0 {
                *own = fall;
            }
        }
    }

    /// The time of the first end of a pulse, if it comes before `next`, as seen from `now`.
    #[inline(always)]
    pub fn first(&self, mut next: C, now: C) -> C {
        if self.high != 0 {
            for (axis, fall) in self.falls.iter().enumerate() {
                if self.high >> axis & 1 != 0 {
                    next = next.first(*fall, now);
                }
            }
        }
        next
    }
}

impl<T: StepTimer, D: Drive, S: Source, const N: usize> Engine<T, D, S, N> {
    /// Ends the pulses of these steps, which began at `edge`, if they are over or nearly so;
    /// otherwise leaves STEP high.
    #[inline(always)]
    pub(super) fn leave_high(&mut self, steps: Axes, edge: T::Count) {
        if steps == 0 {
            return;
        }
        let fall = edge.plus(self.terms.timing.pulse);
        let left = fall.since(self.timer.now());
        if left > T::SPIN as i32 {
            return self.pulses.add(steps, fall);
        }
        if left > 0 {
            self.timer.hold_until(fall);
        }
        self.drive.end(steps);
    }

    /// Waits for the end of the pulses of these steps, which began at `edge`, and ends them.
    #[inline(always)]
    pub(super) fn hold_high(&mut self, steps: Axes, edge: T::Count) {
        if steps != 0 {
            self.timer.hold_until(edge.plus(self.terms.timing.pulse));
            self.drive.end(steps);
        }
    }

    /// Does the one of these two that is right for this timer.
    #[inline(always)]
    pub(super) fn see_to_pulses(&mut self, steps: Axes, edge: T::Count) {
        if Self::LEAVES_HIGH { self.leave_high(steps, edge) } else { self.hold_high(steps, edge) }
    }

    /// Ends the pulses that are over. The next step of the same axis comes no sooner than a pulse
    /// length later, even if this call is late: a driver has to see STEP low.
    #[inline(always)]
    pub(super) fn end_pulses(&mut self, now: T::Count) {
        if !Self::LEAVES_HIGH || self.pulses.high == 0 {
            return;
        }
        let rise = now.plus(self.terms.timing.pulse);
        let mut over: Axes = 0;
        for (axis, (track, fall)) in self.tracks.iter_mut().zip(&self.pulses.falls).enumerate() {
            if self.pulses.high >> axis & 1 == 0 || fall.is_after(now) {
                continue;
            }
            over |= 1 << axis;
            let steps = track.state == State::Play && track.pins & STEP != 0;
            if steps && rise.is_after(track.wake()) {
                track.push = rise.since(T::Count::of(track.due)) as Ticks;
            }
        }
        if over != 0 {
            self.drive.end(over);
            self.pulses.high &= !over;
        }
    }
}
