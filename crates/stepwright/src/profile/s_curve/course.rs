//! The course from any state of motion to rest at a distance: the jerk over time.
//!
//! A motion has a speed v and an acceleration a. There are two ways to continue as fast as the
//! limits allow: to *drive* towards the top speed, and to *stop*. A target is reached by driving
//! for a time x, then stopping:
//!
//! ```text
//!   jerk    +J  0  −J  0     −J  0  +J         v ▲       ____________
//!          └───────────┘    └─────────┘          │     ╱│   cruise   │╲
//!           drive                stop            │    ╱ │            │ ╲
//!                      x ▲                       └───╱──┴────────────┴──╲──► t
//! ```
//!
//! The distance D(x) grows with x, so the x that leads to the target is searched between one that
//! ends short of it and one beyond. A target that even an immediate stop, D(0), would pass is
//! reached by driving the other way: the same, mirrored. (This is the time-optimal solution of a
//! third-order system wherever the acceleration may be passed through freely; see Berscheid,
//! Kröger: *Jerk-limited Real-time Trajectory Generation with Arbitrary Target States*, 2021, for
//! all the cases that a closed form would have to distinguish.)
//!
//! To reach a speed u from a state: ½a|a|/J is gained anyway while a returns to 0, and g is the
//! rest of the difference:
//!
//! ```text
//!   peak² = J·g + max(a, 0)²      if above the limit: held there for the rest
//! ```
//!
//! **Through zero**: braking obeys the deceleration limit, accelerating the acceleration limit. At
//! the moment between them the acceleration is within both, because the jerk limit does not let it
//! jump.

use crate::wide::Wide;

/// The limits of a motion, in steps and seconds; none is 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Limits {
    pub top: Wide,
    /// The acceleration limits while the speed grows and while it falls.
    pub up: Wide,
    pub down: Wide,
    pub jerk: Wide,
    /// The speed at which the motion ends: at most that at which it begins.
    pub end: Wide,
}

/// A speed and an acceleration, signed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Motion {
    pub v: Wide,
    pub a: Wide,
}

impl Motion {
    pub(super) const fn steady(v: Wide) -> Motion {
        Motion { v, a: Wide::ZERO }
    }

    fn flipped(self, minus: bool) -> Motion {
        Motion { v: self.v.flipped(minus), a: self.a.flipped(minus) }
    }

    /// The motion `time` later, at a constant jerk.
    fn after(self, jerk: Wide, time: Wide) -> Motion {
        let change = jerk * time;
        Motion { v: self.v + (self.a + change.scaled(-1)) * time, a: self.a + change }
    }
}

/// A period of constant jerk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stage {
    pub from: Motion,
    pub to: Motion,
    pub jerk: Wide,
    pub time: Wide,
}

impl Stage {
    const NONE: Stage = Stage {
        from: Motion::steady(Wide::ZERO),
        to: Motion::steady(Wide::ZERO),
        jerk: Wide::ZERO,
        time: Wide::ZERO,
    };

    /// The distance of the stage. Computed from its slower end, where the error is least.
    pub(super) fn way(&self) -> Wide {
        let (m, back) = match self.from.v.abs() <= self.to.v.abs() {
            true => (self.from, false),
            false => (self.to, true),
        };
        way(m.v, m.a.flipped(back), self.jerk, self.time)
    }

    fn flipped(self, minus: bool) -> Stage {
        Stage {
            from: self.from.flipped(minus),
            to: self.to.flipped(minus),
            jerk: self.jerk.flipped(minus),
            time: self.time,
        }
    }

    /// The two parts of the stage, before and after `at`, where the motion is `there`.
    fn cut(self, at: Wide, there: Motion, rest: Wide) -> [Stage; 2] {
        [Stage { to: there, time: at, ..self }, Stage { from: there, time: rest, ..self }]
    }

    /// The parts of the stage in which neither the acceleration nor the speed changes its sign.
    pub(super) fn parts(self) -> Stages<4> {
        let mut parts = Stages::EMPTY;
        for part in self.at_no_acceleration() {
            for part in part.at_rest() {
                parts.push(part);
            }
        }
        parts
    }

    /// Divides the stage where the acceleration passes 0.
    fn at_no_acceleration(self) -> [Stage; 2] {
        let (a, b) = (self.from.a, self.to.a);
        if !opposite(a, b) {
            return [self, Stage::NONE];
        }
        let at = a.abs() / self.jerk.abs();
        let there = Motion::steady(self.from.v + (a * at).scaled(-1));
        self.cut(at, there, b.abs() / self.jerk.abs())
    }

    /// Divides the stage where the speed passes 0; the acceleration does not.
    fn at_rest(self) -> [Stage; 2] {
        let (Motion { v, a }, Motion { v: u, a: b }) = (self.from, self.to);
        if !opposite(v, u) {
            return [self, Stage::NONE];
        }
        // a at v = 0 is √(a² − 2jv); the time is a quotient without a difference.
        let sign = if a.is_zero() { b } else { a };
        let there = (a.squared() - (self.jerk * v).scaled(1)).sqrt().flipped(sign.is_minus());
        let half = |v: Wide, a: Wide| (v.scaled(1) / (a + there)).abs();
        let (at, rest) = (half(v, a), half(u, b));
        if at.max(rest) > self.time.scaled(1) {
            // Both speeds are rounding errors of 0: there is nothing to divide.
            return [self, Stage::NONE];
        }
        self.cut(at, Motion { v: Wide::ZERO, a: there }, rest)
    }
}

/// v·t + a·t²/2 + j·t³/6.
pub(super) fn way(v: Wide, a: Wide, j: Wide, t: Wide) -> Wide {
    (v + (a + j * t * Wide::THIRD) * t.scaled(-1)) * t
}

fn opposite(a: Wide, b: Wide) -> bool {
    !a.is_zero() && !b.is_zero() && a.is_minus() != b.is_minus()
}

/// Up to N stages, one after the other; each takes some time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stages<const N: usize> {
    all: [Stage; N],
    len: usize,
}

impl<const N: usize> Stages<N> {
    const EMPTY: Stages<N> = Stages { all: [Stage::NONE; N], len: 0 };

    fn push(&mut self, stage: Stage) {
        if !stage.time.is_plus() {
            return;
        }
        if let Some(slot) = self.all.get_mut(self.len) {
            *slot = stage;
            self.len += 1;
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Stage> {
        self.all.iter().take(self.len).copied()
    }
}

impl<const N: usize> IntoIterator for Stages<N> {
    type Item = Stage;
    type IntoIter = core::iter::Take<core::array::IntoIter<Stage, N>>;

    fn into_iter(self) -> Self::IntoIter {
        self.all.into_iter().take(self.len)
    }
}

/// A drive has at most 7 stages, a stop 3, with a cruise between them.
pub(super) type Course = Stages<11>;

impl Limits {
    /// From `motion` to the speed `to` with acceleration 0. On the way the acceleration is at most
    /// `up` or `down`; if it is more at first, it is brought back.
    fn reach(&self, motion: Motion, to: Wide, up: Wide, down: Wide) -> [Stage; 3] {
        let jerk = self.jerk;
        // The difference to the speed that is reached anyway as the acceleration returns to 0.
        let gain = to - self.at_no_acceleration(motion);
        let minus = gain.is_minus();
        let (gain, most) = (gain.abs(), if minus { down } else { up });
        let (from, to) = (motion.flipped(minus), to.flipped(minus));
        let present = if from.a.is_plus() { from.a.squared() } else { Wide::ZERO };
        let mut peak = (jerk * gain + present).sqrt();
        let mut hold = Wide::ZERO;
        if peak > most {
            // Not below 0 if the acceleration is too large already.
            let ramps = (most.squared() - present) / jerk;
            hold = if ramps.is_minus() { gain / most } else { (gain - ramps) / most };
            peak = most;
        }
        let first = peak - from.a;
        let last = Motion { v: to - (peak.squared() / jerk).scaled(-1), a: peak };
        let held = Motion { v: last.v - peak * hold, a: peak };
        let end = Motion::steady(to);
        [
            Stage {
                from,
                to: held,
                jerk: jerk.flipped(first.is_minus()),
                time: first.abs() / jerk,
            },
            Stage { from: held, to: last, jerk: Wide::ZERO, time: hold },
            Stage { from: last, to: end, jerk: -jerk, time: peak / jerk },
        ]
        .map(|stage| stage.flipped(minus))
    }

    /// To the end speed, as fast as allowed.
    fn stop(&self, motion: Motion) -> [Stage; 3] {
        self.reach(motion, self.end, self.down, self.down)
    }

    /// The speed when the acceleration has been brought back to 0.
    pub(super) fn at_no_acceleration(&self, motion: Motion) -> Wide {
        motion.v + (motion.a * motion.a.abs() / self.jerk).scaled(-1)
    }

    /// The distance of a stop.
    pub(super) fn stopping(&self, motion: Motion) -> Wide {
        self.stop(motion).iter().fold(Wide::ZERO, |sum, stage| sum + stage.way())
    }

    /// To the top speed, as fast as allowed.
    fn drive(&self, motion: Motion) -> Stages<7> {
        let (mut drive, at) = match self.turn(motion) {
            Some((stages, at)) => (stages, at),
            None => (Stages::EMPTY, motion),
        };
        for stage in self.reach(at, self.top, self.up, self.down) {
            drive.push(stage);
        }
        drive
    }

    /// For a motion that goes backward, or would do so soon: the stages to rest, and the
    /// acceleration with which it continues from there. That acceleration is allowed on both sides
    /// of rest and can be brought back to 0 before the top speed.
    fn turn(&self, motion: Motion) -> Option<(Stages<7>, Motion)> {
        if !motion.v.is_minus() && !self.at_no_acceleration(motion).is_minus() {
            return None;
        }
        let least = self.up.min(self.down).squared().scaled(-1) / self.jerk;
        let mut turn = Stages::EMPTY;
        for stage in self.reach(motion, least.min(self.top), self.down, self.down) {
            for part in stage.at_no_acceleration() {
                if part.from.v.is_plus() || !part.to.v.is_plus() {
                    turn.push(part);
                } else if part.from.v.is_zero() {
                    return Some((turn, part.from));
                } else {
                    let [back, _] = part.at_rest();
                    turn.push(back);
                    return Some((turn, back.to));
                }
            }
        }
        None // it goes backward only by rounding
    }

    /// The stages from `motion` to the end speed, `way` steps away.
    pub(super) fn course(&self, motion: Motion, way: Wide) -> Course {
        let mut course = Stages::EMPTY;
        if motion.a.is_zero() && motion.v == self.end && motion.v.is_plus() && way.is_plus() {
            // The jerk may gain too little on the way for a 64-bit speed to represent: its ramps
            // would have any length. Then the motion keeps its speed.
            let time = way / motion.v;
            if self.jerk * time.squared() <= motion.v.scaled(-46) {
                course.push(Stage { from: motion, to: motion, jerk: Wide::ZERO, time });
                return course;
            }
        }
        let over = self.stopping(motion) - way;
        if over.abs() <= way.abs().max(Wide::whole(1)).scaled(-50) {
            // A stop ends there except for rounding. Driving for this small difference, or undoing
            // it, would leave an acceleration at the end, which is small only in these limits.
            for stage in self.stop(motion) {
                course.push(stage);
            }
            return course;
        }
        let minus = over.is_plus();
        let (motion, way) = (motion.flipped(minus), way.flipped(minus));
        let mut gone = Wide::ZERO;
        let mut at = motion;
        let mut far = false;
        for stage in self.drive(motion).iter() {
            let left = way - gone;
            let end = stage.way();
            if end + self.stopping(stage.to) >= left {
                let part = self.part(stage, left);
                course.push(part);
                (at, far) = (part.to, true);
                break;
            }
            course.push(stage);
            gone = gone + end;
            at = stage.to;
        }
        if !far {
            let time = (way - gone - self.stopping(at)) / self.top;
            course.push(Stage { from: at, to: at, jerk: Wide::ZERO, time });
        }
        for stage in self.stop(at) {
            course.push(stage);
        }
        for stage in &mut course.all {
            *stage = stage.flipped(minus);
        }
        course
    }

    /// The part of `stage` that, followed by a stop, leads `left` steps further: a secant search
    /// (Illinois), which halves the interval where the secants converge slowly.
    fn part(&self, stage: Stage, left: Wide) -> Stage {
        let until = |time| Stage { to: stage.from.after(stage.jerk, time), time, ..stage };
        let beyond = |part: &Stage| part.way() + self.stopping(part.to) - left;
        let (mut low, mut high) = (Wide::ZERO, stage.time);
        let (mut short, mut over) = (beyond(&until(low)), beyond(&stage));
        if !over.is_plus() {
            return stage;
        }
        let mut width = high;
        let mut last = None;
        for round in 0..200 {
            let apart = high - low;
            if apart <= high.scaled(-63) || !short.is_minus() {
                break;
            }
            let mut x = low + apart * (short / (short - over));
            if round % 3 == 2 {
                if apart > width.scaled(-3) {
                    x = low + apart.scaled(-1);
                }
                width = apart;
            }
            if x <= low || x >= high {
                x = low + apart.scaled(-1);
            }
            let off = beyond(&until(x));
            let side = off.is_minus();
            // The weight of an end that stays twice is halved.
            let again = last == Some(side);
            if side {
                (low, short) = (x, off);
                over = if again { over.scaled(-1) } else { over };
            } else {
                (high, over) = (x, off);
                short = if again { short.scaled(-1) } else { short };
            }
            last = Some(side);
        }
        until(low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The acceleration at the moment of rest, on the way back from `v` to a target far ahead.
    fn at_rest(v: i64, [top, up, down, jerk]: [u64; 4]) -> Wide {
        let [top, up, down, jerk] = [top, up, down, jerk].map(Wide::whole);
        let limits = Limits { top, up, down, jerk, end: Wide::ZERO };
        let course = limits.course(Motion::steady(Wide::signed(v)), Wide::whole(1_000_000_000));
        let turn = course.iter().find(|stage| stage.from.v.is_minus() && !stage.to.v.is_minus());
        turn.expect("it turns").to.a
    }

    #[track_caller]
    fn near(a: Wide, to: Wide) {
        assert!((a - to).abs() <= to.scaled(-50), "{a:?}, not {to:?}");
    }

    #[test]
    fn rest_is_passed_with_all_that_both_sides_allow() {
        // From far enough back that it brakes with its limit for a while.
        near(at_rest(-100_000, [50_000, 300, 500, 7]), Wide::whole(300));
        near(at_rest(-100_000, [50_000, 300, 300, 7]), Wide::whole(300));
        near(at_rest(-100_000, [50_000, 500, 300, 7]), Wide::whole(300));
        // And with a higher braking limit, which it does not reach.
        near(at_rest(-100_000, [50_000, 300, 5_000, 7]), Wide::whole(300));
    }

    #[test]
    fn rest_is_passed_with_no_more_than_the_top_speed_can_take_back() {
        // a²/2J = 1400 steps/s.
        near(at_rest(-10_000, [1_400, 300, 500, 7]), Wide::whole(140));
        near(at_rest(-10_000, [1_400, 500, 300, 7]), Wide::whole(140));
    }

    #[test]
    fn rest_is_passed_with_all_that_a_slow_motion_gains() {
        // Slower than the ramp that follows: √(2J·v).
        near(at_rest(-1_400, [50_000, 300, 500, 7]), Wide::whole(140));
        near(at_rest(-1_400, [50_000, 500, 300, 7]), Wide::whole(140));
    }
}
