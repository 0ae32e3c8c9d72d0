//! Makes runs of a curve: a tracer that walks the closed form.
//!
//! A run over N steps takes its growth from the intervals c = f/v at both ends and its first
//! interval from the exact time between them, like a run of a [`Cursor`](crate::profile::Cursor).
//! The parabola leaves out the third derivative of the time by the steps,
//!
//! ```text
//!   t‴ = (3a² − j·v) / v⁵          error ≤ N³·max|t‴| / 96
//! ```
//!
//! (The error is zero at both ends, and its slope is the same at both; 1/96 is the largest integral
//! of the kernel for these conditions. A constant t‴ makes 1/125.) Within a piece, speed and
//! acceleration only rise or only fall, so the ends of the run bound t‴. Here t‴ may have either
//! sign; the defect of the trapezoid rule, which bounds a `Cursor`'s run, would not detect it where
//! the sign changes.
//!
//! A run stays within a piece; a step across the boundary of two pieces is a run of its own. Where
//! the curve turns back, a [turn](Run::turns) comes at that moment.

use super::State;
use super::curve::{Curve, Moment};
use crate::profile::cursor::{HALF_TICK, fitted, floor_log2, single};
use crate::profile::{Fit, Runs};
use crate::run::Run;
use crate::wide::Wide;

/// Walks a [`Curve`] and yields its [runs](Run).
///
/// Each run starts from the exact time of the step before it, so any mixture of runs adds up to the
/// curve's own time. A run takes a root of a cubic (some six 64-bit Newton iterations) and three
/// divisions: for hosts.
#[derive(Clone, Debug)]
pub struct Tracer {
    curve: Curve,
    fit: Fit,
    /// The last pulse handed out, its time in 2⁻³² ticks, and its moment.
    n: u32,
    time: u128,
    here: Moment,
    /// The direction of the last run, and whether that run was a turn.
    backward: bool,
    turned: bool,
    /// How far the runs handed out are behind the curve, in 2⁻³² ticks.
    lag: i64,
    /// The run length to try next, as a power of two.
    size: u8,
}

impl Tracer {
    /// A tracer at the curve's first pulse.
    pub fn new(curve: Curve, fit: Fit) -> Tracer {
        Tracer::at(curve, fit, 0)
    }

    /// A tracer at pulse `n`: the next run begins there.
    pub fn at(curve: Curve, fit: Fit, n: u32) -> Tracer {
        let n = n.min(curve.length());
        let here = curve.moment(n, None);
        let backward = curve.leg_of(n).backward;
        let time = curve.ticks(here.time);
        Tracer { curve, fit, n, time, here, backward, turned: false, lag: HALF_TICK, size: 0 }
    }

    /// The last pulse handed out.
    pub fn pulse(&self) -> u32 {
        self.n
    }

    /// Speed and acceleration at the last pulse handed out, from which another curve may begin.
    /// `None` between a turn and the step after it.
    pub fn state(&self) -> Option<State> {
        let leg = self.curve.leg_of(self.n);
        (!self.turned).then(|| State(leg.motion(&self.here)))
    }

    /// Changes to another curve at the last pulse handed out; the curve must begin with this
    /// tracer's [`state`](Self::state). Fractions of a tick are carried over, so that the errors of
    /// several changes don't add up. Does nothing between a turn and the step after it.
    pub fn change(&mut self, curve: Curve) {
        if self.turned {
            return;
        }
        (self.curve, self.n, self.size) = (curve, 0, 0);
        self.here = curve.moment(0, None);
        self.time = curve.ticks(self.here.time);
    }

    /// The curve.
    pub fn curve(&self) -> &Curve {
        &self.curve
    }

    /// The interval at a speed, in 2⁻³² ticks; saturates.
    fn interval(&self, v: Wide) -> u64 {
        let c = Wide::whole(self.curve.rate().hz().into()) / v;
        u64::try_from(c.to_q32()).unwrap_or(u64::MAX)
    }

    /// The largest error in a run of 2^size steps up to `there`, in 2⁻³² ticks.
    fn error(&self, there: &Moment, jerk: Wide, size: u8) -> u64 {
        let slow = self.here.v.min(there.v);
        let fast = self.here.v.max(there.v);
        let steep = self.here.a.abs().max(there.a.abs());
        let (bend, jerk) = (steep.squared() * Wide::whole(3), jerk * fast);
        let third = if jerk.is_plus() { bend.max(jerk) } else { bend - jerk };
        let ratio = Wide::whole(1 << size) / slow;
        let rate = Wide::whole(self.curve.rate().hz().into()) * Wide::THIRD.scaled(-5);
        let error = third * ratio.squared() * ratio / slow.squared() * rate;
        u64::try_from(error.to_q32()).unwrap_or(u64::MAX)
    }

    /// Moves to pulse `m`.
    fn arrive(&mut self, m: u32, there: Moment, lag: i64) {
        (self.n, self.here, self.lag) = (m, there, lag);
        self.time = self.curve.ticks(there.time);
    }

    /// A run of at most `room` ≥ 1 steps within a piece.
    fn within(&mut self, room: u32, jerk: Wide) -> Run {
        let level = jerk.is_zero() && self.here.a.is_zero();
        let most = if level { self.fit.level_size } else { self.fit.ramp_size };
        let room = floor_log2(room).min(most);
        let c = self.interval(self.here.v);
        let mut size = if level { room } else { self.size.min(room) };
        loop {
            size = self.fit.shorter(c, size);
            let m = self.n.saturating_add(1 << size);
            let there = self.curve.moment(m, Some(self.here.tau));
            let time = self.curve.ticks(there.time).saturating_sub(self.time);
            let time = u64::try_from(time).unwrap_or(u64::MAX);
            let error = if level { 0 } else { self.error(&there, jerk, size) };
            let fits = size == 0 || error <= self.fit.error;
            let c2 = if level { c } else { self.interval(there.v) };
            let Some((run, lag)) = fitted(time, self.lag, c, c2, size).filter(|_| fits) else {
                size -= 1; // a single step always fits
                continue;
            };
            self.size = if error.saturating_mul(8) <= self.fit.error {
                size + 1
            } else if there.v < self.here.v && error.saturating_mul(2) > self.fit.error {
                size.saturating_sub(1)
            } else {
                size
            };
            self.arrive(m, there, lag);
            return run;
        }
    }

    /// The single step that leads into another piece.
    fn across(&mut self) -> Run {
        let m = self.n + 1;
        let there = self.curve.moment(m, None);
        let time = self.curve.ticks(there.time).saturating_sub(self.time);
        let (run, lag) = single(u64::try_from(time).unwrap_or(u64::MAX), self.lag);
        self.arrive(m, there, lag);
        self.size = 0;
        run
    }
}

impl Runs for Tracer {
    fn steps_left(&self) -> u32 {
        self.curve.length().saturating_sub(self.n)
    }
}

impl Iterator for Tracer {
    type Item = Run;

    fn next(&mut self) -> Option<Run> {
        if self.n >= self.curve.length() {
            return None;
        }
        let leg = self.curve.leg_of(self.n + 1);
        if leg.backward != self.backward {
            (self.backward, self.turned) = (leg.backward, true);
            // The next step is counted from the turn.
            let turn = self.curve.ticks(leg.begin).max(self.time);
            let wait = u64::try_from(turn - self.time).unwrap_or(u64::MAX);
            let wait = wait.saturating_add_signed(self.lag) >> 32;
            self.time += u128::from(wait) << 32;
            return Some(Run::turn(u32::try_from(wait).unwrap_or(u32::MAX), !self.backward));
        }
        self.turned = false;
        let piece = self.curve.piece_of(self.n + 1);
        if self.n < piece.first {
            return Some(self.across());
        }
        let (room, jerk) = (piece.last - self.n, piece.jerk);
        Some(self.within(room, jerk))
    }
}
