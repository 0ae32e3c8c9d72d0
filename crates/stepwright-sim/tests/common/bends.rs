//! The independent curve of a travel with a limited jerk that is changed on the way: pieces of constant jerk,
//! in f64, from physics alone. It shares no formula with the planner: ramps are built from their durations, and
//! unreachable top speeds and the times of pulses are found by bisection.
//!
//! A change first brings the acceleration to 0 at the jerk limit. From the next pulse at constant speed on, the
//! rest is the quickest way. A leg that already falls to its end is not changed.
//!
//! If rounding, or the progress of a half-planned run, decides between two ways, both are followed; the pulses
//! must keep one of them.

use super::legs::{Gap, Said};
use stepwright::Change;

/// Speeds in steps/s, accelerations in steps/s², the jerk in steps/s³.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub start: f64,
    pub top: f64,
    pub a: f64,
    pub d: f64,
    pub jerk: f64,
}

/// A time with this acceleration at its beginning, which changes at this jerk.
#[derive(Clone, Copy, Debug)]
struct Piece {
    time: f64,
    a: f64,
    jerk: f64,
}

/// Position, speed and acceleration.
#[derive(Clone, Copy, Debug)]
struct State {
    x: f64,
    v: f64,
    a: f64,
}

impl State {
    fn after(self, piece: &Piece, t: f64) -> State {
        let Piece { a, jerk, .. } = *piece;
        State {
            x: self.x + t * (self.v + t * (a / 2.0 + t * jerk / 6.0)),
            v: self.v + t * (a + t * jerk / 2.0),
            a: a + t * jerk,
        }
    }
}

/// A stretch in one direction, from one pulse on.
#[derive(Clone, Debug)]
struct Leg {
    v: f64,
    pieces: Vec<Piece>,
    /// The steps before the last fall.
    fall: f64,
    steps: f64,
    /// Seconds by which its pieces last too long: doubtful steps that the leg does not have.
    excess: f64,
}

/// The ramp from one speed to another, within this acceleration.
fn ramp(from: f64, to: f64, a: f64, jerk: f64) -> Vec<Piece> {
    let change = (to - from).abs();
    if change == 0.0 {
        return Vec::new();
    }
    let bend = (a / jerk).min((change / jerk).sqrt());
    let (peak, sign) = (jerk * bend, (to - from).signum());
    let straight = (change / peak - bend).max(0.0);
    vec![
        Piece { time: bend, a: 0.0, jerk: sign * jerk },
        Piece { time: straight, a: sign * peak, jerk: 0.0 },
        Piece { time: bend, a: sign * peak, jerk: -sign * jerk },
    ]
}

/// The steps that these pieces make.
fn way(v: f64, pieces: &[Piece]) -> f64 {
    let begin = State { x: 0.0, v, a: 0.0 };
    pieces.iter().fold(begin, |state, piece| state.after(piece, piece.time)).x
}

/// A piece at constant speed over these steps.
fn wait(way: f64, v: f64) -> Piece {
    // An endless piece is longer than any test.
    let time = if way > 0.0 { (way / v).min(1e9) } else { 0.0 };
    Piece { time, a: 0.0, jerk: 0.0 }
}

fn fall(v: f64, limits: &Limits) -> Vec<Piece> {
    ramp(v, limits.start.min(v), limits.d, limits.jerk)
}

/// The highest acceleration of these pieces.
fn peak(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|piece| piece.a.abs()).fold(0.0, f64::max)
}

/// By how many steps a bend may be longer or shorter if speeds near v are known to 2⁻²⁸: dv/a in time where a
/// begins or ends, and at most the duration of a bend of dv. The effect on the pulses' times is invisible, but
/// it may cost a step.
fn doubt(v: f64, a: f64, jerk: f64) -> f64 {
    let dv = v * 2f64.powi(-28);
    v * (dv / a).min((2.0 * dv / jerk).sqrt())
}

impl Leg {
    /// The quickest way from constant speed over this many steps to rest; the steps may be infinite.
    fn over(v: f64, steps: f64, limits: &Limits) -> Leg {
        let first = |top: f64| ramp(v, top, if top > v { limits.a } else { limits.d }, limits.jerk);
        let both = |top: f64| way(v, &first(top)) + way(top, &fall(top, limits));
        let hair = steps * 2f64.powi(-30);
        let mut top = limits.top;
        if both(top) > steps + hair {
            let (mut least, mut most) = (v, if top > v { top } else { v });
            for _ in 0..100 {
                let middle = (least + most) / 2.0;
                if both(middle) > steps { most = middle } else { least = middle }
            }
            top = least;
        }
        Leg { v, pieces: Vec::new(), fall: 0.0, steps, excess: 0.0 }.joined(first(top), top, limits)
    }

    /// The leg with these pieces up to the speed `top`, then constant speed, then the fall.
    fn joined(mut self, pieces: Vec<Piece>, top: f64, limits: &Limits) -> Leg {
        let fall = fall(top, limits);
        self.pieces.extend(pieces);
        self.fall = self.steps - way(top, &fall);
        let level = self.fall - way(self.v, &self.pieces);
        self.excess = (-level / top).max(0.0);
        self.pieces.push(wait(level, top));
        self.pieces.extend(fall);
        self
    }

    /// Seconds that the ramps last, as their times are computed from their ends.
    fn ramps(&self) -> f64 {
        let bent = |piece: &&Piece| piece.a != 0.0 || piece.jerk != 0.0;
        self.pieces.iter().filter(bent).map(|piece| piece.time).sum()
    }

    /// Seconds from pulse 0 to pulse s, and the state at s.
    fn at(&self, s: f64) -> (f64, State) {
        let (mut time, mut state) = (0.0, State { x: 0.0, v: self.v, a: 0.0 });
        state.a = self.pieces.first().map_or(0.0, |piece| piece.a);
        if s == 0.0 {
            return (time, state);
        }
        for piece in &self.pieces {
            let end = state.after(piece, piece.time);
            // The last pulse comes at the end of all pieces: near rest, a rounding of the position takes very
            // long.
            if end.x >= s && s < self.steps {
                // Newton's method, with bisection if a step leads out of bounds.
                let (mut least, mut most, mut t) = (0.0, piece.time, piece.time);
                for _ in 0..200 {
                    let here = state.after(piece, t);
                    if here.x < s {
                        least = t
                    } else {
                        most = t
                    }
                    let next = t - (here.x - s) / here.v;
                    let inside = next > least && next < most;
                    let next = if inside { next } else { (least + most) / 2.0 };
                    if next == t {
                        break;
                    }
                    t = next;
                }
                return (time + t, State { x: s, ..state.after(piece, t) });
            }
            (time, state) = (time + piece.time, end);
        }
        (time, state)
    }
}

/// Follows the pulses of one travel, and knows everything that was said.
#[derive(Clone)]
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
}

type Follows<T> = Result<T, String>;

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
    fn check(&self, upto: usize) -> Follows<()> {
        for s in 0..=upto {
            let Some(&(time, position)) = self.pulses.get(self.first + s) else {
                return Err(format!("pulse {s} of {upto} is missing: {:?}", self.leg));
            };
            if position != self.place + self.sign() * s as i64 {
                return Err(format!("pulse {s} is at {position}: {:?}", self.leg));
            }
            let (passed, state) = self.leg.at(s as f64);
            let passed = passed * self.hz;
            let off = time as f64 - self.time - passed;
            let age = self.since + passed.max(self.leg.ramps() * self.hz);
            // After a long ease, the rounding of its steps is made up for at the low speed.
            let left = if s as f64 <= self.leg.fall { s as f64 * 2f64.powi(-28) } else { 0.0 };
            let slack = self.slack + (self.leg.excess + left / state.v.max(1e-3)) * self.hz;
            if off.abs() > slack + age * 2f64.powi(-26) {
                return Err(format!("pulse {s} is {off} ticks off: {:?}", self.leg));
            }
        }
        Ok(())
    }

    /// The present leg has ended, before or beyond the target: begins the next one, from rest.
    fn turn(&mut self, gap: &Gap) -> Follows<()> {
        let steps = self.leg.steps as usize;
        self.check(steps)?;
        let end = self.first + steps;
        self.place += self.sign() * steps as i64;
        let target = self.target.ok_or("an endless leg ended")?;
        let (last, Some(next)) = (self.pulses[end].0 as f64, self.pulses.get(end + 1)) else {
            return Err("no leg follows".into());
        };
        let next = next.0 as f64;
        let [least, most] = self.rests();
        let least = gap.least.max(least - 1.0);
        if target == self.place || next - last < least || next - last > gap.most + most {
            return Err(format!(
                "a turn in {} ticks, from {} to {target}",
                next - last,
                self.place
            ));
        }
        self.forward = target > self.place;
        let way = (target - self.place).abs() as f64;
        self.place += self.sign();
        (self.first, self.time, self.since) = (end + 1, next, 0.0);
        self.leg = Leg::over(self.limits.start, way - 1.0, &self.limits);
        Ok(())
    }

    /// Whether this was said while the present leg was being planned.
    fn covers(&self, said: &Said) -> bool {
        let s = (i64::from(said.planned) - self.place) * self.sign();
        said.forward == self.forward && (0..).contains(&s) && s as f64 <= self.leg.steps
    }

    /// Goes on to where this was said, and applies it in every way in which it may have been taken.
    pub fn hear(mut self, said: &Said, gap: &Gap) -> Follows<Vec<Self>> {
        while !self.covers(said) {
            self.turn(gap)?;
        }
        let s = (i64::from(said.planned) - self.place) * self.sign();
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
        let s = s as f64;
        let mut ways = Vec::new();
        let top = self.leg.at(self.leg.fall.max(0.0)).1.v;
        let last = &self.leg.pieces[self.leg.pieces.len().saturating_sub(3)..];
        let near = 1e-6 * (1.0 + self.leg.fall.abs()) + doubt(top, peak(last), self.limits.jerk);
        if s == self.leg.steps || s + 1.0 > self.leg.fall - near {
            // It falls already, or may fall.
            let mut way = self.clone();
            if said.change.is_none() {
                way.target = Some(self.place + self.sign() * self.leg.steps as i64);
            }
            ways.push(way);
        }
        if s < self.leg.steps && s <= self.leg.fall + near {
            self.check(s as usize)?;
            self.turn_over(s, &mut ways);
        }
        Ok(ways)
    }

    /// Whether both are the same from here on.
    pub fn is_like(&self, other: &Self) -> bool {
        let state = |way: &Self| (way.first, way.place, way.target, way.leg.pieces.len());
        let near = |a: f64, b: f64| a == b || (a - b).abs() < 1e-9 * a.abs();
        let mut pieces = self.leg.pieces.iter().zip(&other.leg.pieces);
        state(self) == state(other)
            && self.leg.steps == other.leg.steps
            && near(self.time, other.time)
            && pieces.all(|(a, b)| near(a.time, b.time))
    }

    /// From pulse s on the acceleration goes to 0, and the rest is planned again.
    fn turn_over(mut self, s: f64, ways: &mut Vec<Self>) {
        let stop = self.braking;
        let (passed, state) = self.leg.at(s);
        self.time += passed * self.hz;
        self.since += passed * self.hz;
        self.first += s as usize;
        self.place += self.sign() * s as i64;
        let time = state.a.abs() / self.limits.jerk;
        let go = Piece { time, a: state.a, jerk: -state.a.signum() * self.limits.jerk };
        let level = State { x: 0.0, ..state }.after(&go, time);
        let last = fall(level.v, &self.limits);
        let short = way(level.v, &last);
        let jerk = self.limits.jerk;
        let doubt_here = doubt(state.v, state.a.abs(), jerk);
        let doubt_short = doubt_here + doubt(level.v, peak(&last), jerk);
        let left = self.target.map_or(f64::INFINITY, |t| ((t - self.place) * self.sign()) as f64);
        let left = if stop { 0.0 } else { left };
        let begun = Leg { v: state.v, pieces: vec![go], fall: 0.0, steps: 0.0, excess: 0.0 };
        let mut add = |leg: Leg| {
            let mut way = Follower { leg, ..self.clone() };
            if stop {
                way.target = Some(self.place + self.sign() * way.leg.steps as i64);
            }
            ways.push(way);
        };
        // The whole numbers of steps that a doubtful way may have.
        let near = |x: f64, doubt: f64| {
            let by = 1e-9 + x * 2f64.powi(-27) + doubt;
            let [least, most] = [x - by, x + by].map(|x| x.ceil().max(0.0) as u32);
            (least..=most).map(f64::from)
        };
        let mut seen = Vec::new();
        for least in near(level.x + short, doubt_short) {
            for pulse in near(level.x, doubt_here) {
                let brakes = left <= least;
                let end = if brakes { (least, 0.0) } else { (left, pulse) };
                if seen.contains(&(brakes, end)) {
                    continue;
                }
                seen.push((brakes, end));
                let mut leg = Leg { steps: end.0, ..begun.clone() };
                if brakes {
                    add(leg.joined(Vec::new(), level.v, &self.limits));
                    continue;
                }
                let rest = Leg::over(level.v, left - pulse, &self.limits);
                leg.pieces.push(wait(pulse - level.x, level.v));
                leg.pieces.extend(rest.pieces);
                (leg.fall, leg.excess) = (pulse + rest.fall, rest.excess);
                add(leg);
            }
        }
    }

    /// Follows to the end, after all has been said.
    pub fn finish(mut self, gap: &Gap) -> Follows<()> {
        let target = self.target.ok_or("it never ends")?;
        while self.place + self.sign() * self.leg.steps as i64 != target {
            self.turn(gap)?;
        }
        self.check(self.leg.steps as usize)?;
        let end = self.first + self.leg.steps as usize + 1;
        if self.pulses.len() != end {
            return Err(format!("{} pulses beyond the end", self.pulses.len() - end));
        }
        Ok(())
    }
}
