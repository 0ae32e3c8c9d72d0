//! An axis as its edges show it.

mod change;
mod pace;
mod planned;

use stepwright_sim::{Edge, Pin};

use crate::fault::{Fault, Rule, Rules};
use crate::limits::Limits;
use crate::stops::Stops;
use planned::Planned;

/// Yes, no, or not visible from outside.
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

    /// Whether either is.
    pub fn or(self, other: Known) -> Known {
        match (self, other) {
            (Known::Yes, _) | (_, Known::Yes) => Known::Yes,
            (Known::No, Known::No) => Known::No,
            _ => Known::Maybe,
        }
    }
}

/// The tolerances and times for the edges of a board, in ticks.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// Ticks per second.
    pub hz: f64,
    /// The most that an edge may be off its time.
    pub jitter: f64,
    /// The most that an interval within a run may be off that of the law.
    pub fit: f64,
    /// The width of a pulse by the settings.
    pub pulse: u64,
    /// The time of DIR before STEP.
    pub setup: u64,
    /// The time of DIR after STEP.
    pub hold: u64,
    /// The ticks by which a simulation reports edges early or late.
    pub slack: u64,
    /// The time after which a closed switch has stopped its axis.
    pub switch: u64,
    /// The rules to check.
    pub rules: Rules,
}

/// The last order of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Goal {
    /// Rest.
    Rest,
    /// End at this position before this time.
    End(i64, u64),
    /// Move on without an end.
    Endless,
    /// Brake, and rest before this time.
    Stop(u64),
    /// Not visible from outside: the axis may have been stopped on its way.
    Open,
}

/// The limits before a change.
#[derive(Clone, Copy, Debug)]
struct Past {
    limits: Limits,
    /// They hold for what was planned when the change came.
    planned: Planned,
    /// Their top speed holds until this time; `None` until the change is obeyed.
    top_until: Option<u64>,
    /// Their deceleration may hold until the end of a fall.
    falls: bool,
}

/// A soft stop.
#[derive(Clone, Copy, Debug)]
struct Braked {
    /// The time of the order.
    told: u64,
    /// What was planned at that time.
    planned: Planned,
    /// An interval after that has been judged. From now on none is shorter than the one before.
    falls: bool,
}

/// An axis.
#[derive(Clone, Debug)]
pub struct Track {
    /// 0 for X.
    pub axis: u8,
    /// Steps forward minus steps backward, through everything.
    pub count: i64,
    /// The count at position 0.
    pub zero: i64,
    /// Whether the board knows its position.
    pub known: Known,
    /// The last order.
    pub goal: Goal,
    /// The count at the start of the travel.
    pub origin: i64,
    /// The least allowed count.
    pub least: i64,
    /// The greatest allowed count.
    pub most: i64,
    /// Whether forward is a low DIR.
    pub reverse: bool,
    /// The time before which the driver allows no step.
    pub not_before: u64,
    /// The times since when the switches are closed, backward and forward.
    pub closed: [Option<u64>; 2],
    /// The possible causes of its stop.
    pub stops: Stops,
    /// The soft limits of its travel, both inclusive.
    pub fence: Option<(i64, i64)>,
    /// Whether its endless travel ends at a soft limit.
    pub bounded: Known,
    /// Whether a stop input will have stopped it: after the last `!`, or perhaps before it.
    pub doomed: Known,
    /// The limits of its travel.
    pub limits: Limits,
    /// The highest top speed since the order.
    pub highest: f64,
    /// Earlier limits that may still hold.
    before: Vec<Past>,
    /// Whether the travel got another target.
    retargeted: bool,
    /// The time of the last order of a target.
    told: u64,
    /// The order to brake.
    braked: Option<Braked>,
    /// What was planned at the last order of a target, until that is played.
    ahead_of_goal: Option<Planned>,
    /// Whether it may have been halted at once. Then its last interval does not count.
    halted: bool,
    /// The ticks by which its last steps are ahead of the top speed, and by which they may be.
    ahead: (f64, f64),
    level: Option<bool>,
    high: bool,
    rise: Option<u64>,
    turned: Option<u64>,
    /// The direction of the last step.
    forward: Option<bool>,
    /// The interval before the last step of the present leg.
    interval: Option<u64>,
    /// The loosest limits by which that interval was planned.
    by: Limits,
    /// The least rest after the travel before, in s.
    rested: f64,
    /// The least rest after this travel, in s.
    rests: f64,
    /// Whether the present leg has no step yet.
    fresh: bool,
    /// The number of steps so far.
    pub steps: u64,
}

impl Track {
    /// The state at power-up.
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
            fence: None,
            bounded: Known::No,
            doomed: Known::No,
            limits: Limits::new(50, 1_000_000, 200, 0, 0, 0),
            highest: 0.0,
            before: Vec::new(),
            retargeted: false,
            told: 0,
            braked: None,
            ahead_of_goal: None,
            halted: false,
            ahead: (0.0, 0.0),
            level: None,
            high: false,
            rise: None,
            turned: None,
            forward: None,
            interval: None,
            by: Limits::new(50, 1_000_000, 200, 0, 0, 0),
            rested: 0.0,
            rests: 0.0,
            fresh: true,
            steps: 0,
        }
    }

    /// Handles a reset of the board: pins and motion begin from the start, the count continues.
    pub fn reset(&mut self, known: Known) {
        let old = self.clone();
        *self = Track::new(self.axis);
        (self.count, self.zero, self.least, self.most) =
            (old.count, old.count, old.count, old.count);
        (self.steps, self.closed, self.known) = (old.steps, old.closed, known);
    }

    /// Whether its travel has no step yet.
    pub fn is_fresh(&self) -> bool {
        self.fresh
    }

    /// Whether the axis may rest now because of another target, before it turns or goes on: a leg may end
    /// with its last interval.
    pub fn may_turn(&self, measure: &Measure) -> bool {
        self.retargeted && self.interval.is_none_or(|interval| self.may_end(interval, measure))
    }

    /// The time of the last step.
    pub fn last(&self) -> Option<u64> {
        self.rise
    }

    /// The time of the step before the last one.
    pub fn last_but_one(&self) -> Option<u64> {
        Some(self.rise?.saturating_sub(self.interval.unwrap_or(0)))
    }

    /// The highest possible present speed, by the last interval or the first. Edges are in whole ticks, so
    /// the interval may be longer than the motion's. No speed is above the top speed.
    fn speed(&self, measure: &Measure) -> f64 {
        match self.interval {
            Some(interval) => {
                let short = measure.hz / (interval as f64 - measure.jitter).max(0.5);
                short.min(self.highest.max(measure.hz / interval.max(1) as f64))
            }
            None => 1.0 / self.limits.first(),
        }
    }

    /// Whether the axis moves or has yet to move.
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

    /// Whether `stop=` may show this letter for the axis now. If so, it becomes the only possible one. L
    /// replaces `-` if the axis has ended at its soft limit.
    pub fn shows(&mut self, letter: u8, now: u64, measure: &Measure) -> bool {
        let ended = match (self.bounded, self.busy(now, measure).not()) {
            (Known::No, _) | (_, Known::No) => Known::No,
            (Known::Yes, Known::Yes) => Known::Yes,
            _ => Known::Maybe,
        };
        let fits = match letter {
            b'L' => ended != Known::No && self.stops.are(b'-'),
            b'-' => ended != Known::Yes && self.stops.are(b'-'),
            _ => self.stops.are(letter),
        };
        match (letter, ended) {
            _ if !fits => {}
            (b'L', _) => self.bounded = Known::Yes,
            (b'-', _) => {}
            _ => self.bounded = Known::No,
        }
        fits
    }

    /// The ticks after the last step in which nobody outside can tell whether the travel has ended: a step
    /// away from its end may be planned by the limits before a change.
    fn grace(&self, measure: &Measure) -> u64 {
        ((0.03 + 2.0 * self.slowest()) * measure.hz) as u64 + measure.setup + measure.hold
    }

    /// Sets the limits of the next travel.
    pub fn order(&mut self, limits: Limits) {
        self.rested = self.rests.min(self.limits.rest());
        self.rests = limits.rest();
        self.before.clear();
        self.highest = limits.top;
        self.limits = limits;
    }

    /// Begins a travel of `steps`, or without an end. It takes `wait` ticks more than its motion.
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
        (self.braked, self.ahead_of_goal, self.halted) = (None, None, false);
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

    /// Handles a stop at once, or an axis that is not judged further: its speed no longer counts.
    pub fn halt(&mut self) {
        self.goal = Goal::Rest;
        (self.least, self.most) = (self.count, self.count);
        (self.fresh, self.interval) = (true, None);
    }

    /// Takes note that the board says that the axis rests.
    ///
    /// # Errors
    /// The axis is not where it was ordered to, or stopped dead.
    pub fn rest(&mut self, now: u64, measure: &Measure) -> Result<(), Fault> {
        let Track { axis, count, .. } = *self;
        if let Goal::End(end, _) = self.goal
            && end != count
        {
            let what = || format!("axis {} rests {} steps off its end", axis + 1, count - end);
            measure.rules.broken(Rule::Count, now, what)?;
        }
        let ended = matches!(self.goal, Goal::End(..) | Goal::Stop(_)) && !self.halted;
        (self.goal, self.doomed) = (Goal::Rest, Known::No);
        (self.least, self.most) = (count, count);
        if ended { self.stopped(now, measure) } else { Ok(()) }
    }

    /// Checks that a travel has ended in time.
    ///
    /// # Errors
    /// The travel has not.
    pub fn due(&self, now: u64, measure: &Measure) -> Result<(), Fault> {
        match self.goal {
            Goal::End(end, by) if now > by && self.count != end => {
                let (axis, left) = (self.axis + 1, end - self.count);
                measure.rules.broken(Rule::Time, now, || {
                    format!("axis {axis} should have ended by tick {by}, {left} steps to go")
                })
            }
            _ => Ok(()),
        }
    }

    /// Judges an edge of this axis.
    ///
    /// # Errors
    /// The broken rule.
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
            (Pin::Coil(_) | Pin::Enable | Pin::Min | Pin::Max, _) => {}
        }
        Ok(())
    }

    /// Judges a step.
    fn step(&mut self, now: u64, measure: &Measure) -> Result<(), Fault> {
        let axis = self.axis + 1;
        let rules = measure.rules;
        let forward = self.level.unwrap_or(true) != self.reverse;
        self.count += if forward { 1 } else { -1 };
        self.steps += 1;
        let (least, most, count) = (self.least, self.most, self.count);
        if count < least || count > most {
            let goal = self.goal;
            let what =
                || format!("axis {axis} steps to {count}, beyond {least} … {most}; {goal:?}");
            rules.broken(Rule::Order, now, what)?;
        }
        if let Some((behind, ahead)) = self.fence
            && !(behind..=ahead).contains(&count)
        {
            rules.broken(Rule::Limit, now, || {
                format!("axis {axis} steps to {count}, beyond a soft limit: {behind} … {ahead}")
            })?;
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
        let paced = self.slows(now, forward, measure).and(self.pace(now, forward, measure));
        let begins = self.fresh || self.forward == Some(!forward);
        (self.forward, self.fresh, self.rise) = (Some(forward), false, Some(now));
        self.play(now, begins, measure);
        paced
    }
}
