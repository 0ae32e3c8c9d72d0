//! Effects of a change on an axis' bounds during a travel: other limits, another target, a stop.

use super::planned::Planned;
use super::{Braked, Goal, Known, Measure, Past, Track};
use crate::limits::{Limits, Way};

impl Track {
    /// The limits in force; the loosest if several may be.
    pub(super) fn in_force(&self, now: u64) -> Limits {
        self.before.iter().fold(self.limits, |limits, past| {
            let held = past.planned.has(self.rise, now);
            let mut limits = if held { limits.or(&past.limits) } else { limits };
            if past.top_until.is_none_or(|until| now < until) {
                limits.top = limits.top.max(past.limits.top);
            }
            if past.falls {
                limits.down = limits.down.max(past.limits.down);
            }
            limits
        })
    }

    /// Handles a new leg or a rising speed: a fall that had begun before a change is over.
    pub(super) fn end_falls(&mut self, now: u64) {
        let last = self.rise;
        self.before.iter_mut().for_each(|past| past.falls &= past.planned.has(last, now));
    }

    /// The longest time of a first or last step, in s.
    pub(super) fn slowest(&self) -> f64 {
        let all = self.before.iter().map(|past| &past.limits).chain([&self.limits]);
        all.map(|limits| limits.first().max(limits.last())).fold(0.0, f64::max)
    }

    /// The longest rest after the travel so far, in s. A change that came when the end was already planned
    /// does not apply to this rest.
    pub fn longest_rest(&self) -> f64 {
        let last = self.rise.unwrap_or(0);
        let held = self.before.iter().filter(|past| past.planned.has(self.rise, last));
        held.fold(self.limits.rest(), |rest, past| rest.max(past.limits.rest()))
    }

    /// Sets the limits from now on for a travel in progress.
    pub fn limit(&mut self, now: u64, limits: Limits, measure: &Measure) {
        // A lower deceleration takes longer to reach an earlier top speed, too.
        self.before.iter_mut().for_each(|past| past.top_until = None);
        // With a limit of jerk a fall that has begun continues to its end after any change.
        let falls = limits.jerk.is_finite();
        let planned = self.planned(now, measure);
        self.before.push(Past { limits: self.limits, planned, top_until: None, falls });
        self.rests = self.rests.min(limits.rest());
        self.highest = self.highest.max(limits.top);
        self.limits = limits;
        match self.goal {
            Goal::Stop(_) => {
                // A lower deceleration needs a longer way.
                (self.least, self.most) = (i64::MIN, i64::MAX);
                self.goal = Goal::Open;
                let braked = self.braked;
                self.brake(now, measure);
                self.braked = braked;
            }
            // The axis may be braking, and may now brake for longer, or go beyond its end and back.
            Goal::Open => {
                let way = self.way(now, measure).steps;
                let way = way.min(1e15) as i64;
                self.least = self.least.min(self.count.saturating_sub(way));
                self.most = self.most.max(self.count.saturating_add(way));
                self.retargeted = true;
            }
            Goal::Rest | Goal::End(..) | Goal::Endless => {}
        }
        self.may_overshoot(now, measure);
        self.extend(now, measure);
    }

    /// Records what is planned by now.
    fn planned(&mut self, now: u64, measure: &Measure) -> Planned {
        let (lazy, v) = (self.lazy(now), self.speed(measure));
        // A limit of jerk delays the acceleration beyond what is planned.
        let bend = lazy.bend(lazy.top.max(v));
        let (begins, slow) = if self.fresh {
            (now.max(self.told), self.longest_rest() + 3.0 * self.slowest())
        } else {
            (now, self.slowest() + 3.0 / v)
        };
        let slow = begins + self.ticks(slow + bend, measure);
        let planned = Planned::new(now, self.fresh, measure.hz, bend, slow);
        self.ahead_of_goal = Some(planned);
        planned
    }

    /// Takes note of a step, perhaps the first of a leg, which plays a part of what was planned before
    /// changes. After all of it is played, the speed gives the longest way to rest.
    pub(super) fn play(&mut self, now: u64, begins: bool, measure: &Measure) {
        let plans = self.before.iter_mut().map(|past| &mut past.planned);
        let plans = plans.chain(self.braked.iter_mut().map(|braked| &mut braked.planned));
        plans.chain(&mut self.ahead_of_goal).for_each(|planned| planned.step(begins));
        if self.ahead_of_goal.is_none_or(|planned| !planned.is_played(now)) {
            return;
        }
        self.ahead_of_goal = None;
        let v = self.interval.map(|interval| {
            let v = measure.hz / (interval as f64 - measure.jitter - measure.fit).max(0.5);
            (v, self.by.end_speed(v))
        });
        let way = self.lazy(now).way_from(v, self.slowest());
        let until = now + self.ticks(way.time + 0.005, measure);
        self.before.iter_mut().for_each(|past| {
            past.top_until.get_or_insert(until);
        });
        let steps = way.steps.min(1e15) as i64;
        let end = match &mut self.goal {
            Goal::End(end, _) if self.retargeted => *end,
            Goal::Stop(by) => {
                *by = until.min(*by);
                self.count
            }
            _ => return,
        };
        self.least = self.least.max(end.min(self.count) - steps);
        self.most = self.most.min(end.max(self.count) + steps);
    }

    /// The way to rest of an axis that learns of the order now. The speed at the end of its last interval
    /// depends on the limits of that time, which may be higher than those of now.
    fn way(&self, now: u64, measure: &Measure) -> Way {
        let (lazy, v) = (self.lazy(now), self.speed(measure));
        let by = if self.interval.is_some() { lazy.or(&self.by) } else { lazy };
        let last = self.rise.filter(|_| !self.fresh).unwrap_or(now);
        lazy.way(by.end_speed(v), (now - last) as f64 / measure.hz, self.slowest())
    }

    /// Extends the deadline of a changed travel.
    fn extend(&mut self, now: u64, measure: &Measure) {
        if let Goal::End(end, by) = self.goal {
            let way = self.way(now, measure);
            let slower = |slow: Limits, past: &Past| slow.slower(&past.limits);
            let slow = self.before.iter().fold(self.limits, slower);
            let steps = (end - self.count).abs() as f64 + 2.0 * way.steps;
            // The axis may rest before it turns.
            let rests = self.before.iter().map(|past| past.limits.rest());
            let rest = rests.fold(self.limits.rest(), f64::max);
            let time = way.time * 2.0 + slow.duration(steps) + 4.0 * self.slowest() + rest;
            let wait = measure.setup + 2 * measure.hold;
            let begins = if self.fresh { now.max(self.told) } else { now };
            self.goal = Goal::End(end, by.max(begins + self.ticks(time, measure) + wait));
        }
    }

    fn lazy(&self, now: u64) -> Limits {
        let held = self.before.iter().filter(|past| past.planned.has(self.rise, now) || past.falls);
        held.fold(self.limits, |limits, past| limits.lazier(&past.limits))
    }

    /// Extends the bounds of a travel in progress: it may brake, turn and come back.
    fn may_overshoot(&mut self, now: u64, measure: &Measure) {
        let Goal::End(end, _) = self.goal else { return };
        let again = std::mem::replace(&mut self.retargeted, true);
        let way = self.way(now, measure).steps.min(1e15) as i64;
        let (mut least, mut most) = (self.count.min(end), self.count.max(end));
        match self.forward.filter(|_| !self.fresh) {
            Some(true) => most = most.max(self.count + way),
            Some(false) => least = least.min(self.count - way),
            None if end > self.origin => most = most.max(self.count + way),
            None => least = least.min(self.count - way),
        }
        // The axis may be about to turn, or on its way back.
        if again {
            (least, most) = (least.min(self.count - way), most.max(self.count + way));
        }
        // The axis may already be on its way further out.
        if self.fresh {
            (least, most) = (least.min(self.origin - way), most.max(self.origin + way));
        }
        (self.least, self.most) = (least, most);
    }

    /// Sets another target, counted from the start of the travel.
    pub fn retarget(&mut self, now: u64, steps: i64, measure: &Measure) {
        let end = self.origin + steps;
        self.goal = Goal::End(end, now);
        (self.told, self.braked) = (self.told.max(now), None);
        self.planned(now, measure);
        self.may_overshoot(now, measure);
        self.extend(now, measure);
    }

    /// Handles a soft stop.
    pub fn brake(&mut self, now: u64, measure: &Measure) {
        let (Goal::End(..) | Goal::Endless | Goal::Open) = self.goal else { return };
        let way = self.way(now, measure);
        let steps = way.steps.min(1e15) as i64;
        let (back, ahead) = match self.forward.filter(|_| !self.fresh) {
            // A turn and its first step may be in progress.
            Some(true) => (if self.retargeted { steps } else { 0 }, steps),
            Some(false) => (steps, if self.retargeted { steps } else { 0 }),
            None => (steps, steps),
        };
        self.least = self.least.max(self.count - back);
        self.most = self.most.min(self.count + ahead);
        // The axis may not have begun, or may turn and rest before.
        let rests = self.before.iter().map(|past| past.limits.rest());
        let rest = self.ticks(rests.fold(self.limits.rest(), f64::max), measure);
        let begins = if self.fresh { self.told.max(self.not_before) } else { now };
        let wait = begins.saturating_sub(now) + rest + measure.setup + 2 * measure.hold;
        let by = now + wait + self.ticks(way.time, measure);
        self.goal = Goal::Stop(by);
        let planned = self.planned(now, measure);
        self.braked = Some(Braked { told: now, planned, falls: false });
    }

    /// Handles a cause that may have stopped the axis: it may brake because of a silence, or may have been
    /// halted. From outside this is not visible.
    pub fn open(&mut self, letter: u8) {
        if self.goal == Goal::Rest {
            return;
        }
        let brakes = matches!(self.goal, Goal::Stop(_));
        if letter == b'T' {
            self.stops.soft(letter, Known::Maybe);
            // An axis that brakes already continues to brake.
            if !brakes {
                self.goal = Goal::Open;
            }
        } else {
            self.stops.hard(letter, Known::Maybe);
            (self.goal, self.halted) = (Goal::Open, true);
        }
    }
}
