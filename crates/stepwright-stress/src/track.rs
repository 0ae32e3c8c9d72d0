//! One axis, as its edges show it.

use stepwright_sim::{Edge, Pin};

use crate::fault::{Fault, Rule, Rules};
use crate::limits::Limits;
use crate::stops::Stops;

/// Yes, no, or not to be told from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Known {
    No,
    Maybe,
    Yes,
}

impl Known {
    /// The opposite.
    #[expect(clippy::should_implement_trait)] // it is three-valued
    pub fn not(self) -> Known {
        match self {
            Known::No => Known::Yes,
            Known::Maybe => Known::Maybe,
            Known::Yes => Known::No,
        }
    }

    /// Whether any of two is.
    pub fn or(self, other: Known) -> Known {
        match (self, other) {
            (Known::Yes, _) | (_, Known::Yes) => Known::Yes,
            (Known::No, Known::No) => Known::No,
            _ => Known::Maybe,
        }
    }
}

/// What the edges of a board are measured by, in ticks.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// Ticks per second.
    pub hz: f64,
    /// An edge may come so much beside its time.
    pub jitter: f64,
    /// Within a run an interval may be so much beside that of the law.
    pub fit: f64,
    /// The widths that the settings ask for.
    pub pulse: u64,
    /// DIR before STEP.
    pub setup: u64,
    /// DIR after STEP.
    pub hold: u64,
    /// Edges are so many ticks early or late in a simulation.
    pub slack: u64,
    /// A closed switch has stopped its axis after so long.
    pub switch: u64,
    /// The rules that are looked at.
    pub rules: Rules,
}

/// What an axis was told last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    /// To rest.
    Rest,
    /// To end there, before so late.
    End(i64, u64),
    /// To go on.
    Endless,
    /// To brake, and rest before so late.
    Stop(u64),
    /// What it does can't be told from outside: it may be stopped on its way.
    Open,
}

/// An interval of a ramp may be so much of itself beside the law: a run is a parabola.
const CLOSE: f64 = 1.002;

/// An axis.
#[derive(Clone, Debug)]
pub struct Track {
    /// 0 for X.
    pub axis: u8,
    /// Steps forward minus steps backward, through everything.
    pub count: i64,
    /// Where position 0 is.
    pub zero: i64,
    /// Whether its position is known to the board.
    pub known: Known,
    /// What it was told.
    pub goal: Goal,
    /// Where the travel began.
    pub origin: i64,
    /// It may be from here …
    pub least: i64,
    /// … to here.
    pub most: i64,
    /// Forward is a low DIR.
    pub reverse: bool,
    /// No step before, for the driver's sake.
    pub not_before: u64,
    /// Closed switches, backward and forward, since when.
    pub closed: [Option<u64>; 2],
    /// Why it has stopped.
    pub stops: Stops,
    /// The limits of its travel.
    pub limits: Limits,
    /// The highest top speed since its order.
    pub highest: f64,
    /// Limits that may still hold, and until when; the top speed for longer.
    before: Vec<(Limits, u64, u64)>,
    /// The travel got another target on its way.
    retargeted: bool,
    /// When it was told last where to go.
    told: u64,
    level: Option<bool>,
    high: bool,
    rise: Option<u64>,
    turned: Option<u64>,
    /// Direction of the last step.
    forward: Option<bool>,
    /// The interval before the last step of the present leg.
    interval: Option<u64>,
    /// How long it rests after the travel before, at least, in s.
    rested: f64,
    /// And after this one.
    rests: f64,
    /// The present leg has not begun.
    fresh: bool,
    /// Steps so far.
    pub steps: u64,
}

impl Track {
    /// As at power-up.
    pub fn new(axis: u8) -> Track {
        Track {
            axis,
            count: 0,
            zero: 0,
            known: Known::Yes,
            goal: Goal::Rest,
            origin: 0,
            least: 0,
            most: 0,
            reverse: false,
            not_before: 0,
            closed: [None; 2],
            stops: Stops::NONE,
            limits: Limits::new(50, 1000, 200, 0, 0, 0),
            highest: 0.0,
            before: Vec::new(),
            retargeted: false,
            told: 0,
            level: None,
            high: false,
            rise: None,
            turned: None,
            forward: None,
            interval: None,
            rested: 0.0,
            rests: 0.0,
            fresh: true,
            steps: 0,
        }
    }

    /// The board has begun again, and so do pins and motion; the count goes on.
    pub fn reset(&mut self, known: Known) {
        let old = self.clone();
        *self = Track::new(self.axis);
        (self.count, self.zero, self.least, self.most) =
            (old.count, old.count, old.count, old.count);
        (self.steps, self.closed, self.known) = (old.steps, old.closed, known);
    }

    /// Its travel has not made a step.
    pub fn is_fresh(&self) -> bool {
        self.fresh
    }

    /// When it stepped last.
    pub fn last(&self) -> Option<u64> {
        self.rise
    }

    /// The present speed, roughly: of the last interval, or of the first.
    fn speed(&self, measure: &Measure) -> f64 {
        match self.interval {
            Some(interval) => measure.hz / interval.max(1) as f64,
            None => 1.0 / self.limits.first(),
        }
    }

    /// Whether it moves, or has yet to.
    pub fn busy(&self, now: u64, measure: &Measure) -> Known {
        match self.goal {
            Goal::Rest => Known::No,
            Goal::End(end, _) if self.count != end => Known::Yes,
            Goal::End(..) if now > self.rise.unwrap_or(0).max(self.told) + self.grace(measure) => {
                Known::No
            }
            Goal::Stop(by) if now > by => Known::No,
            Goal::End(..) | Goal::Stop(_) | Goal::Open => Known::Maybe,
            Goal::Endless => Known::Yes,
        }
    }

    /// Ticks after the last step in which nobody outside can tell whether the travel has
    /// ended.
    fn grace(&self, measure: &Measure) -> u64 {
        let slowest = self.limits.first().max(self.limits.last());
        ((0.03 + 2.0 * slowest) * measure.hz) as u64 + measure.setup + measure.hold
    }

    /// It has other limits from its next travel on.
    pub fn order(&mut self, limits: Limits) {
        self.rested = self.rests.min(self.limits.rest());
        self.rests = limits.rest();
        self.before.clear();
        self.highest = limits.top;
        self.limits = limits;
    }

    /// A travel begins: so far, or on and on. It takes `wait` ticks more than its motion.
    pub fn begin(
        &mut self,
        now: u64,
        steps: Option<i64>,
        forward: bool,
        wait: u64,
        measure: &Measure,
    ) {
        self.told = now + wait;
        self.before.clear();
        self.origin = self.count;
        self.retargeted = false;
        (self.fresh, self.interval) = (true, None);
        match steps {
            Some(steps) => {
                let end = self.count + steps;
                (self.least, self.most) = (self.count.min(end), self.count.max(end));
                self.goal = Goal::End(
                    end,
                    now + wait + self.ticks(self.limits.duration(steps.abs() as f64), measure),
                );
            }
            None => {
                self.goal = Goal::Endless;
                (self.least, self.most) =
                    if forward { (self.count, i64::MAX) } else { (i64::MIN, self.count) };
            }
        }
    }

    fn ticks(&self, seconds: f64, measure: &Measure) -> u64 {
        (seconds * measure.hz).min(1e18) as u64
    }

    /// The limits in force, the loosest where several may be.
    fn in_force(&self, now: u64) -> Limits {
        self.before.iter().fold(self.limits, |limits, (before, until, top_until)| {
            let mut limits = if now < *until { limits.or(before) } else { limits };
            if now < *top_until {
                limits.top = limits.top.max(before.top);
            }
            limits
        })
    }

    /// How long a first or last step may take, in s.
    fn slowest(&self) -> f64 {
        let all = self.before.iter().map(|(before, ..)| before).chain([&self.limits]);
        all.map(|limits| limits.first().max(limits.last())).fold(0.0, f64::max)
    }

    /// Other limits from now on, for a travel in progress.
    pub fn limit(&mut self, now: u64, limits: Limits, measure: &Measure) {
        let before = self.in_force(now);
        let v = self.speed(measure);
        let slowest = self.slowest().max(limits.first()).max(limits.last());
        let lag = limits.lag(v) + 3.0 * slowest;
        let way = self.lazy(now).lazier(&limits).way(v.max(before.top.min(v * 4.0)), slowest);
        let until = now + self.ticks(lag, measure);
        let top_until = until + self.ticks(way.time, measure);
        // A lower deceleration takes longer to come down to a top speed of before, too.
        for (.., held) in self.before.iter_mut().filter(|(.., held)| now < *held) {
            *held = top_until.max(*held);
        }
        self.before.push((self.limits, until, top_until));
        self.rests = self.rests.min(limits.rest());
        self.highest = self.highest.max(limits.top);
        self.limits = limits;
        if let Goal::Stop(_) = self.goal {
            // A lower deceleration takes a longer way.
            (self.least, self.most) = (i64::MIN, i64::MAX);
            self.goal = Goal::Open;
            self.brake(now, measure);
        }
        self.may_overshoot(now, measure);
        self.extend(now, measure);
    }

    /// The deadline of a travel that was changed.
    fn extend(&mut self, now: u64, measure: &Measure) {
        if let Goal::End(end, by) = self.goal {
            let way = self.lazy(now).way(self.speed(measure), self.slowest());
            let slower = |slow: Limits, (before, ..): &(Limits, u64, u64)| slow.slower(before);
            let slow = self.before.iter().fold(self.limits, slower);
            let steps = (end - self.count).abs() as f64 + 2.0 * way.steps;
            let time = way.time * 2.0 + slow.duration(steps) + 4.0 * self.slowest();
            let wait = measure.setup + 2 * measure.hold;
            self.goal = Goal::End(end, by.max(now + self.ticks(time, measure) + wait));
        }
    }

    fn lazy(&self, now: u64) -> Limits {
        let held = self.before.iter().filter(|(_, until, _)| now < *until);
        held.fold(self.limits, |limits, (before, ..)| limits.lazier(before))
    }

    /// A travel in progress may brake, turn and come back.
    fn may_overshoot(&mut self, now: u64, measure: &Measure) {
        let Goal::End(end, _) = self.goal else { return };
        let again = std::mem::replace(&mut self.retargeted, true);
        let way = self.lazy(now).way(self.speed(measure), self.slowest()).steps.min(1e15) as i64;
        let (mut least, mut most) = (self.count.min(end), self.count.max(end));
        match self.forward.filter(|_| !self.fresh) {
            Some(true) => most = most.max(self.count + way),
            Some(false) => least = least.min(self.count - way),
            None if end > self.origin => most = most.max(self.count + way),
            None => least = least.min(self.count - way),
        }
        // It may be about to turn, and on its way back.
        if again {
            (least, most) = (least.min(self.count - way), most.max(self.count + way));
        }
        // It may have been on its way further out already.
        if self.fresh {
            (least, most) = (least.min(self.origin - way), most.max(self.origin + way));
        }
        (self.least, self.most) = (least, most);
    }

    /// Another target, from where the travel began.
    pub fn retarget(&mut self, now: u64, steps: i64, measure: &Measure) {
        let end = self.origin + steps;
        self.goal = Goal::End(end, now);
        self.told = self.told.max(now);
        self.may_overshoot(now, measure);
        self.extend(now, measure);
    }

    /// A soft stop.
    pub fn brake(&mut self, now: u64, measure: &Measure) {
        let (Goal::End(..) | Goal::Endless | Goal::Open) = self.goal else { return };
        let way = self.lazy(now).way(self.speed(measure), self.slowest());
        let steps = way.steps.min(1e15) as i64;
        let (back, ahead) = match self.forward.filter(|_| !self.fresh) {
            // A turn may be under way, and its first step.
            Some(true) => (if self.retargeted { steps } else { 0 }, steps),
            Some(false) => (steps, if self.retargeted { steps } else { 0 }),
            None => (steps, steps),
        };
        self.least = self.least.max(self.count - back);
        self.most = self.most.min(self.count + ahead);
        // It may have yet to begin, or to turn and rest before.
        let rests = self.before.iter().map(|(before, ..)| before.rest());
        let rest = self.ticks(rests.fold(self.limits.rest(), f64::max), measure);
        let begins = if self.fresh { self.told.max(self.not_before) } else { now };
        let wait = begins.saturating_sub(now) + rest + measure.setup + 2 * measure.hold;
        let by = now + wait + self.ticks(way.time, measure);
        self.goal = Goal::Stop(by);
    }

    /// From outside it can't be told any more whether it goes on.
    pub fn open(&mut self, letter: u8) {
        if self.goal != Goal::Rest {
            self.goal = Goal::Open;
            match letter {
                b'T' => self.stops.soft(letter, Known::Maybe),
                _ => self.stops.hard(letter, Known::Maybe),
            }
        }
    }

    /// It was stopped at once, or will not be looked at: nothing of its speed counts.
    pub fn halt(&mut self) {
        self.goal = Goal::Rest;
        (self.least, self.most) = (self.count, self.count);
        (self.fresh, self.interval) = (true, None);
    }

    /// The board says that it rests.
    ///
    /// # Errors
    /// If it does not stand where it was ordered to, or stopped dead.
    pub fn rest(&mut self, now: u64, measure: &Measure) -> Result<(), Fault> {
        let Track { axis, count, .. } = *self;
        if let Goal::End(end, _) = self.goal
            && end != count
        {
            let what = || format!("axis {} rests {} steps off its end", axis + 1, count - end);
            measure.rules.broken(Rule::Count, now, what)?;
        }
        let ended = matches!(self.goal, Goal::End(..) | Goal::Stop(_));
        self.goal = Goal::Rest;
        (self.least, self.most) = (count, count);
        if ended { self.stopped(now, measure) } else { Ok(()) }
    }

    /// The leg has ended: its last interval was slow enough.
    fn stopped(&self, now: u64, measure: &Measure) -> Result<(), Fault> {
        let Some(interval) = self.interval else { return Ok(()) };
        let limits = self.in_force(self.rise.unwrap_or(now));
        let wide = interval as f64 + measure.jitter + measure.fit;
        let v = measure.hz / wide;
        if v > (limits.start + limits.down * wide / 2.0 / measure.hz) * 1.001 {
            let axis = self.axis + 1;
            measure.rules.broken(Rule::Fall, now, || {
                format!("axis {axis} stops dead at {v:.1} steps/s; {limits:?}")
            })?;
        }
        Ok(())
    }

    /// Time has come to `now`: travels that should have ended.
    ///
    /// # Errors
    /// If one has not.
    pub fn due(&self, now: u64, measure: &Measure) -> Result<(), Fault> {
        match self.goal {
            Goal::End(end, by) if now > by && self.count != end => {
                let (axis, left) = (self.axis + 1, end - self.count);
                measure.rules.broken(Rule::Count, now, || {
                    format!("axis {axis} should have ended by tick {by}, {left} steps to go")
                })
            }
            _ => Ok(()),
        }
    }

    /// An edge of this axis.
    ///
    /// # Errors
    /// What it breaks.
    pub fn edge(&mut self, edge: Edge, measure: &Measure) -> Result<(), Fault> {
        let now = edge.time;
        let short = |from: Option<u64>, least: u64| {
            from.filter(|from| now - from + measure.slack < least).map(|from| now - from)
        };
        let axis = self.axis + 1;
        match (edge.pin, edge.level) {
            (Pin::Step, true) => {
                self.high = true;
                if let Some(got) = short(self.turned, measure.setup) {
                    measure.rules.broken(Rule::Direction, now, || {
                        format!("axis {axis} steps {got} ticks after DIR, not {}", measure.setup)
                    })?;
                }
                if let Some(got) = short(self.rise, 2 * measure.pulse) {
                    measure.rules.broken(Rule::Pulse, now, || {
                        format!(
                            "axis {axis} steps {got} ticks after a step: two pulses are {}",
                            2 * measure.pulse
                        )
                    })?;
                }
                self.step(now, measure)?;
            }
            (Pin::Step, false) => {
                if let Some(got) = short(self.rise, measure.pulse).filter(|_| self.high) {
                    measure.rules.broken(Rule::Pulse, now, || {
                        format!("axis {axis}: STEP is high for {got} ticks, not {}", measure.pulse)
                    })?;
                }
                self.high = false;
            }
            (Pin::Direction, level) => {
                if let Some(got) = short(self.rise, measure.hold) {
                    measure.rules.broken(Rule::Direction, now, || {
                        format!(
                            "axis {axis}: DIR changes {got} ticks after STEP, not {}",
                            measure.hold
                        )
                    })?;
                }
                (self.level, self.turned) = (Some(level), Some(now));
            }
            (Pin::Enable | Pin::Min | Pin::Max, _) => {}
        }
        Ok(())
    }

    /// A step.
    fn step(&mut self, now: u64, measure: &Measure) -> Result<(), Fault> {
        let axis = self.axis + 1;
        let rules = measure.rules;
        let forward = self.level.unwrap_or(true) != self.reverse;
        self.count += if forward { 1 } else { -1 };
        self.steps += 1;
        let (least, most, count) = (self.least, self.most, self.count);
        if count < least || count > most {
            let rule = if matches!(self.goal, Goal::Stop(_)) { Rule::Stop } else { Rule::Order };
            let goal = self.goal;
            let what =
                || format!("axis {axis} steps to {count}, beyond {least} … {most}; {goal:?}");
            rules.broken(rule, now, what)?;
        }
        if let Goal::Stop(by) = self.goal
            && now > by
        {
            rules.broken(Rule::Stop, now, || {
                format!("axis {axis} steps after tick {by}, the end of its stop")
            })?;
        }
        if now < self.not_before {
            let from = self.not_before;
            rules.broken(Rule::Driver, now, || {
                format!("axis {axis} steps before its driver is ready at tick {from}")
            })?;
        }
        if let Some(since) = self.closed[usize::from(forward)]
            && now > since + measure.switch
        {
            rules.broken(Rule::Switch, now, || {
                format!("axis {axis} steps towards a switch that closed at tick {since}")
            })?;
        }
        let paced = self.pace(now, forward, measure);
        (self.forward, self.fresh, self.rise) = (Some(forward), false, Some(now));
        paced
    }

    /// What a step tells of speed and acceleration.
    fn pace(&mut self, now: u64, forward: bool, measure: &Measure) -> Result<(), Fault> {
        let Some(rise) = self.rise else { return Ok(()) };
        let ticks = now - rise;
        let turn = self.forward.is_some_and(|was| was != forward);
        if self.fresh || turn {
            let stopped = if self.fresh { Ok(()) } else { self.stopped(now, measure) };
            self.interval = None;
            return stopped.and(self.dwell(now, ticks, measure));
        }
        let before = self.interval.replace(ticks);
        let limits = self.in_force(now);
        let Measure { hz, jitter, rules, .. } = *measure;
        let axis = self.axis + 1;
        let fastest = hz / (ticks as f64 + jitter);
        if fastest > limits.top * CLOSE {
            rules.broken(Rule::Top, now, || {
                format!("axis {axis} at {fastest:.1} steps/s, with a top speed of {}", limits.top)
            })?;
        }
        let jitter = jitter + measure.fit;
        let (wide, narrow) = (ticks as f64 + jitter, (ticks as f64 - jitter).max(0.5));
        let v = hz / wide;
        // From rest, or from the interval before.
        let mut most = limits.start + limits.up * wide / 2.0 / hz;
        if let Some(last) = before {
            let last = last as f64;
            let both = (last + wide + jitter) / 2.0 / hz;
            most = most.max(hz / (last - jitter).max(0.5) + limits.up * both);
            let fast = hz / (last + jitter);
            let ends = (limits.start + limits.down * (last + jitter) / 2.0 / hz) * 1.001;
            if hz / narrow < (fast - limits.down * both) * 0.999
                && fast > ends
                && last < self.rests * hz
            {
                rules.broken(Rule::Fall, now, || {
                    format!("axis {axis} falls from {fast:.1} to {v:.1} steps/s; {limits:?}")
                })?;
            }
        }
        if v > most * 1.001 {
            let last = before;
            rules.broken(Rule::Rise, now, || {
                format!("axis {axis} rises to {v:.1} steps/s, at most {most:.1}, from an interval of {last:?}; {limits:?}")
            })?;
        }
        Ok(())
    }

    /// The first step of a leg: so long after the last one of another.
    fn dwell(&self, now: u64, ticks: u64, measure: &Measure) -> Result<(), Fault> {
        let least = self.rests.min(self.rested) * measure.hz;
        if (ticks as f64) + measure.jitter < least * 0.99 {
            let axis = self.axis + 1;
            measure.rules.broken(Rule::Dwell, now, || {
                format!("axis {axis} starts {ticks} ticks after its last step, not {least:.0}")
            })?;
        }
        Ok(())
    }
}
