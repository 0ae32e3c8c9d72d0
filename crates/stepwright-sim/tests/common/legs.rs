//! The independent curve of a travel that is changed on the way: legs from rest to rest, each cut where a
//! change took effect.
//!
//! In f64, with the commands of the serial line, from physics alone: constant accelerations between speeds. It
//! shares no formula with the planner.

use stepwright::Change;

/// Speeds in steps/s, accelerations in steps/s².
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub start: f64,
    pub top: f64,
    pub a: f64,
    pub d: f64,
    /// One of [`HAIRS`].
    pub hair: f64,
}

/// A stretch in one direction: a first ramp up or down, constant speed, and a fall.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// The speeds at pulse 0, between the ramps, and at the end.
    v0: f64,
    v_top: f64,
    v_end: f64,
    d: f64,
    /// The steps from pulse 0 to the beginning and the end of the constant speed, and to rest.
    level: f64,
    fall: f64,
    pub steps: f64,
}

/// By how much longer than the available way a fall may be and still count as fitting, as a part of it.
/// Rounding decides between these two: a story is followed with the first and, if that fails, with the second.
pub const HAIRS: [f64; 2] = [1.0 / (1u64 << 31) as f64, 1.0 / (1 << 26) as f64];

impl Leg {
    /// The way to rest from this speed.
    fn way(v: f64, limits: &Limits) -> f64 {
        ((v * v - limits.start * limits.start) / (2.0 * limits.d)).max(0.0)
    }

    /// The part of that way that a hair is.
    fn hair(v: f64, limits: &Limits) -> f64 {
        limits.hair * v * v / (2.0 * limits.d)
    }

    /// The shortest stop that ends at a pulse, from this speed.
    pub fn brake(v: f64, limits: &Limits) -> Leg {
        let way = Leg::way(v, limits);
        let steps = (way - Leg::hair(v, limits)).max(0.0).ceil();
        let fall = (steps - way).max(0.0);
        Leg { v0: v, v_top: v, v_end: limits.start.min(v), d: limits.d, level: 0.0, fall, steps }
    }

    /// The quickest way from this speed over this many steps to rest; the steps may be infinite. A stop if they
    /// are too few.
    pub fn over(v: f64, steps: f64, limits: &Limits) -> Leg {
        let &Limits { start, top, a, d, .. } = limits;
        if steps < Leg::way(v, limits) - Leg::hair(v, limits) {
            return Leg::brake(v, limits);
        }
        let mut leg = Leg { v0: v, v_top: top, v_end: start, d, level: 0.0, fall: 0.0, steps };
        leg.fall = steps - ((top * top - start * start) / (2.0 * d)).max(0.0);
        if v > top {
            // To the new top speed in whole steps, or straight to rest if they don't fit.
            let ease = (v * v - top * top) / (2.0 * d) - Leg::hair(v, limits);
            leg.level = ease.max(0.0).ceil();
            if leg.level > leg.fall + Leg::hair(v, limits) {
                (leg.v_top, leg.level, leg.fall) = (v, 0.0, steps - Leg::way(v, limits));
                leg.fall = leg.fall.max(0.0);
            }
            return leg;
        }
        leg.level = (top * top - v * v) / (2.0 * a);
        if leg.level > leg.fall {
            // v² + 2ax = start² + 2d(steps − x)
            let x = (2.0 * d * steps + start * start - v * v) / (2.0 * (a + d));
            let x = x.max(0.0);
            (leg.level, leg.fall, leg.v_top) = (x, x, (v * v + 2.0 * a * x).sqrt());
        }
        leg
    }

    /// The speed at pulse s.
    pub fn speed(&self, s: f64) -> f64 {
        if s < self.level {
            let part = s / self.level;
            (self.v0 * self.v0 * (1.0 - part) + self.v_top * self.v_top * part).sqrt()
        } else if s <= self.fall {
            self.v_top
        } else {
            (self.v_end * self.v_end + 2.0 * self.d * (self.steps - s)).sqrt()
        }
    }

    /// Seconds from pulse 0 to pulse s, with each stretch at its mean speed.
    pub fn time(&self, s: f64) -> f64 {
        let mean =
            |steps: f64, v: f64, w: f64| if steps > 0.0 { 2.0 * steps / (v + w) } else { 0.0 };
        let (first, level) = (s.min(self.level), s.min(self.fall) - self.level);
        mean(first, self.v0, self.speed(first))
            + mean(level, self.v_top, self.v_top)
            + mean(s - self.fall.max(0.0), self.v_top.min(self.speed(self.fall)), self.speed(s))
    }
}

/// When something was said, by the planned position then, in steps from the travel's origin, and the planned
/// direction.
#[derive(Clone, Copy, Debug)]
pub struct Said {
    pub planned: i32,
    pub forward: bool,
    /// `None`: a soft stop.
    pub change: Option<Change>,
}

/// Follows the pulses of one travel, and knows everything that was said.
pub struct Follower<'a> {
    /// Time and position of each pulse, in ticks and steps from the origin.
    pulses: &'a [(u64, i64)],
    hz: f64,
    limits: Limits,
    /// `None`: endless.
    target: Option<i64>,
    leg: Leg,
    forward: bool,
    /// It was told to stop, and got no target since.
    braking: bool,
    /// Pulse 0 of the leg, by number and by position.
    first: usize,
    place: i64,
    /// When pulse 0 of the leg is due, and how long ago that time was taken from a pulse.
    time: f64,
    since: f64,
    slack: f64,
    /// The highest and the lowest acceleration that were in force.
    accels: [f64; 2],
    /// The same for the top speed.
    tops: [f64; 2],
    worst: f64,
}

/// Ticks from the last pulse before a turn to the first one after.
pub struct Gap {
    pub least: f64,
    pub most: f64,
}

impl<'a> Follower<'a> {
    /// Begins with the first leg, from rest.
    pub fn new(
        pulses: &'a [(u64, i64)],
        hz: f64,
        limits: Limits,
        target: Option<i64>,
        forward: bool,
        slack: f64,
    ) -> Self {
        let place = if forward { 1 } else { -1 };
        let limits = Limits { start: limits.start.min(limits.top), ..limits };
        let left = target.map_or(f64::INFINITY, |t| (t - place).abs() as f64);
        let leg = Leg::over(limits.start, left, &limits);
        assert_eq!(pulses[0].1, place, "the first pulse");
        let time = pulses[0].0 as f64;
        Follower {
            pulses,
            hz,
            limits,
            target,
            leg,
            forward,
            braking: false,
            first: 0,
            place,
            time,
            since: 0.0,
            slack,
            accels: [limits.a; 2],
            tops: [limits.top; 2],
            worst: 0.0,
        }
    }

    /// The shortest and the longest rest between two legs, in ticks: an interval of the start speed, or from
    /// rest the first interval of a ramp, but at least an interval of the top speed.
    fn rests(&self) -> [f64; 2] {
        let start = self.limits.start;
        let first = |a: f64| if start > 0.0 { 1.0 / start } else { (2.0 / a).sqrt() };
        [0, 1].map(|n| first(self.accels[n]).max(1.0 / self.tops[n]) * self.hz)
    }

    fn sign(&self) -> i64 {
        if self.forward { 1 } else { -1 }
    }

    /// Compares the leg's pulses up to this one with the edges.
    fn check(&mut self, upto: usize) {
        for s in 0..=upto {
            let Some(&(time, position)) = self.pulses.get(self.first + s) else {
                panic!("pulse {s} of {upto} is missing: {:?} from {}", self.leg, self.place);
            };
            assert_eq!(
                position,
                self.place + self.sign() * s as i64,
                "pulse {s} of {:?}",
                self.leg
            );
            let passed = self.leg.time(s as f64) * self.hz;
            let off = (time as f64 - self.time - passed).abs();
            let allowed = self.slack + (self.since + passed) * 2f64.powi(-28);
            assert!(
                off <= allowed,
                "pulse {s} is {off} ticks off (since {}): {:?}",
                self.since,
                self.leg
            );
            self.worst = self.worst.max(off);
        }
    }

    /// The present leg has ended, before or beyond the target: begins the next one, from rest.
    fn turn(&mut self, gap: &Gap) {
        let steps = self.leg.steps as usize;
        self.check(steps);
        let end = self.first + steps;
        self.place += self.sign() * steps as i64;
        let target = self.target.expect("an endless leg ended");
        assert_ne!(target, self.place, "a pulse beyond the target");
        let way = (target - self.place).abs() as f64;
        let (last, next) = (self.pulses[end].0 as f64, self.pulses[end + 1].0 as f64);
        let [least, most] = self.rests();
        assert!(next - last >= gap.least.max(least - 1.0), "a turn in {} ticks", next - last);
        assert!(next - last <= gap.most + most, "a turn takes {} ticks", next - last);
        self.forward = target > self.place;
        self.place += self.sign();
        (self.first, self.time, self.since) = (end + 1, next, 0.0);
        self.leg = Leg::over(self.limits.start, way - 1.0, &self.limits);
    }

    /// Whether this was said while the present leg was being planned.
    fn covers(&self, said: &Said) -> bool {
        let s = (i64::from(said.planned) - self.place) * self.sign();
        said.forward == self.forward && (0..).contains(&s) && s as f64 <= self.leg.steps
    }

    /// Goes on to where this was said, and applies it.
    pub fn hear(&mut self, said: &Said, gap: &Gap) {
        while !self.covers(said) {
            self.turn(gap);
        }
        let s = ((i64::from(said.planned) - self.place) * self.sign()) as usize;
        match said.change {
            None => self.braking = true,
            Some(Change::Target(target)) => {
                self.target = Some(target.into());
                self.braking = false;
            }
            Some(Change::Top(top)) => {
                let top = f64::from(top.millisteps()) / 1e3;
                self.limits.top = top;
                self.tops = [self.tops[0].max(top), self.tops[1].min(top)];
            }
            Some(Change::Accel(a)) => {
                let a = a.millisteps() as f64 / 1e3;
                self.limits.a = a;
                self.accels = [self.accels[0].max(a), self.accels[1].min(a)];
            }
            Some(Change::Decel(d)) => self.limits.d = d.millisteps() as f64 / 1e3,
        }
        if s as f64 == self.leg.steps {
            // The leg is planned to its end: the change takes effect after it.
            if said.change.is_none() {
                self.target = Some(said.planned.into());
            }
            return;
        }
        self.check(s);
        let v = self.leg.speed(s as f64);
        let passed = self.leg.time(s as f64) * self.hz;
        self.time += passed;
        self.since += passed;
        self.first += s;
        self.place = said.planned.into();
        let left = self.target.map_or(f64::INFINITY, |t| ((t - self.place) * self.sign()) as f64);
        self.leg = Leg::over(v, left, &self.limits);
        if self.braking {
            self.leg = Leg::brake(v, &self.limits);
            self.target = Some(self.place + self.sign() * self.leg.steps as i64);
        }
    }

    /// Follows to the end, after all has been said. Returns the largest deviation, in ticks.
    pub fn finish(mut self, gap: &Gap) -> f64 {
        let target = self.target.expect("it never ends");
        while self.place + self.sign() * self.leg.steps as i64 != target {
            self.turn(gap);
        }
        self.check(self.leg.steps as usize);
        let end = self.first + self.leg.steps as usize + 1;
        assert_eq!(self.pulses.len(), end, "pulses beyond the end");
        assert_eq!(self.pulses.last().unwrap().1, target);
        self.worst
    }
}
