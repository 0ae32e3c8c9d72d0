//! The rules of the documentation for each line: whether it is accepted, and its effect.

mod rates;

use crate::fault::Fault;
use crate::grammar::Line;
use crate::guard::Travel;
use crate::judge::Judge;
use crate::limits::Limits;
use crate::reason::{Reason, Reasons};
use crate::settings::{self, Settings};
use crate::stops::Stops;
use crate::track::{Goal, Known, Track};

/// The right answers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Expect {
    /// Y, or the requested value, is right.
    pub yes: bool,
    /// E is right for one of these reasons.
    pub no: Reasons,
}

impl Expect {
    /// E only.
    pub fn no(why: impl Into<Reasons>) -> Expect {
        Expect { yes: false, no: why.into() }
    }

    pub(crate) const YES: Expect = Expect { yes: true, no: Reasons::NONE };

    /// E while the axis is busy.
    fn idle(busy: Known) -> Expect {
        Expect::unless(busy, Reason::Busy)
    }

    /// E if `bad`.
    pub(crate) fn unless(bad: Known, why: Reason) -> Expect {
        match bad {
            Known::No => Expect::YES,
            Known::Maybe => Expect { yes: true, no: why.into() },
            Known::Yes => Expect::no(why),
        }
    }

    /// Both conditions have to hold.
    pub(crate) fn and(self, other: Expect) -> Expect {
        Expect { yes: self.yes && other.yes, no: self.no | other.no }
    }
}

/// The parameters of an axis.
#[derive(Clone, Copy, Debug)]
struct Manner {
    start: u32,
    top: u32,
    ramp: u32,
    up: u32,
    down: u32,
    jerk: u32,
    /// The travel of the open order.
    staged: Option<Travel>,
    /// The limits of the travel in progress. A change begins with them.
    travel: Limits,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Open {
    No,
    Yes,
    Spoiled(Reasons),
    /// The order may have been spoiled.
    Doubted(Reasons),
}

/// Whether the axis of the last A still applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Naming {
    /// An order has used the axis, or there was no A.
    Used,
    /// A has named an axis, and no order has used it.
    Said,
    /// PO came: the axis may be axis 1 or that of A.
    Unclear,
}

/// The state of the slave after the lines so far.
#[derive(Clone, Debug)]
pub struct Slave {
    axes: Vec<Manner>,
    /// Bit 0 is axis 1. All bits are set for A0.
    pub selected: u8,
    order: Open,
    naming: Naming,
    /// The number of lines answered E.
    pub refusals: u64,
    /// The reasons for the last E.
    pub last: Option<Reasons>,
}

impl Slave {
    /// The state at power-up.
    pub fn new(axes: usize) -> Slave {
        let (start, top, ramp) = (50, 1_000_000, 200);
        let travel = Limits::new(start, top, ramp, 0, 0, 0);
        let manner = Manner { start, top, ramp, up: 0, down: 0, jerk: 0, staged: None, travel };
        Slave {
            axes: vec![manner; axes],
            selected: 1,
            order: Open::No,
            naming: Naming::Used,
            refusals: 0,
            last: None,
        }
    }

    /// Handles a line that was answered E.
    pub fn refused(&mut self, line: Option<Line>, why: Reasons, empty: bool) {
        if !empty {
            self.refusals += 1;
            self.last = Some(why);
        }
        match (line, self.order) {
            (Some(Line::Run(_)), Open::No) => self.forget(),
            (_, Open::Yes) => self.order = Open::Spoiled(why),
            (_, Open::Doubted(first)) => self.order = Open::Spoiled(first | why),
            _ => {}
        }
    }

    /// Spoils an open order: E will be refused.
    pub fn spoil(&mut self, why: Reasons) {
        match self.order {
            Open::Yes => self.order = Open::Spoiled(why),
            Open::Doubted(first) => self.order = Open::Spoiled(first | why),
            Open::No | Open::Spoiled(_) => {}
        }
    }

    /// Notes that an open order may have been spoiled.
    pub fn may_spoil(&mut self, why: Reasons) {
        match self.order {
            Open::Yes => self.order = Open::Doubted(why),
            Open::Doubted(first) => self.order = Open::Doubted(first | why),
            Open::No | Open::Spoiled(_) => {}
        }
    }

    fn forget(&mut self) {
        self.axes.iter_mut().for_each(|axis| axis.staged = None);
    }

    fn chosen(&mut self) -> impl Iterator<Item = &mut Manner> {
        let selected = self.selected;
        self.axes
            .iter_mut()
            .enumerate()
            .filter(move |(n, _)| selected >> n & 1 != 0)
            .map(|(_, axis)| axis)
    }
}

impl Manner {
    fn limits(&self) -> Limits {
        Limits::new(self.start, self.top, self.ramp, self.up, self.down, self.jerk)
    }

    /// Whether the settings allow these parameters, exactly.
    fn allowed(&self, settings: &Settings) -> Expect {
        let most = u64::from(settings.get(settings::MAX_ACCEL));
        // A fraction of a step/s counts as a whole step/s.
        let (vs, vt) = (u64::from(self.start), u64::from(self.top.div_ceil(1000)));
        let counted = (self.up == 0 || self.down == 0) && vt > vs && most < 100_000_000;
        let steep = u64::from(self.up.max(self.down)) > most
            || counted && vt * vt - vs * vs > 2 * u64::from(self.ramp) * most;
        let fast =
            if vt > u64::from(settings.get(settings::MAX_SPEED)) { Known::Yes } else { Known::No };
        let steep = if steep { Known::Yes } else { Known::No };
        let jerk = self.jerk != 0 && settings.get(settings::LAW) == 0;
        let jerk = if jerk { Known::Yes } else { Known::No };
        let slopes = Expect::unless(steep, Reason::Ramp).and(Expect::unless(jerk, Reason::NoJerk));
        Expect::unless(fast, Reason::TooFast).and(slopes)
    }
}

impl Judge {
    /// The right answers to a line at this time.
    pub(crate) fn expect(&self, line: Line, now: u64) -> Expect {
        let slave = &self.slave;
        let speaks =
            matches!(line, Line::Manner(..) | Line::Go(_) | Line::Run(_) | Line::Retarget(_));
        if speaks && slave.naming == Naming::Unclear {
            return Expect::no(Reason::NoAxis);
        }
        let busy = self.busy(slave.selected, now);
        let axis = |axis: u8| {
            let there = usize::from(axis) <= self.tracks.len();
            Expect::unless(if there { Known::No } else { Known::Yes }, Reason::Axis)
        };
        match line {
            Line::Program => Expect::idle(busy),
            Line::Manner(letter, number) => match letter {
                b'm' | b'a' | b'd' if busy != Known::No && slave.order == Open::No => {
                    self.change(letter, number, now)
                }
                _ => Expect::idle(busy),
            },
            Line::Go(_) if slave.order == Open::No => Expect::no(Reason::NoPo),
            Line::Go(_) => Expect::idle(busy),
            Line::Run(forward) => match slave.order {
                Open::No => {
                    let travels = (0..self.tracks.len()).map(|n| {
                        (slave.selected >> n & 1 != 0).then_some(Travel::Endless(forward))
                    });
                    let start = self.start(travels.collect(), now);
                    match busy {
                        Known::Yes => Expect::idle(busy),
                        _ => Expect::idle(busy).and(start),
                    }
                }
                _ => Expect::idle(busy),
            },
            Line::Retarget(steps) => self.retarget(steps, now),
            Line::Execute => match slave.order {
                Open::No => Expect::no(Reason::NoPo),
                Open::Spoiled(why) => Expect::no(why),
                Open::Yes => self.start(slave.axes.iter().map(|axis| axis.staged).collect(), now),
                Open::Doubted(why) => {
                    let start =
                        self.start(slave.axes.iter().map(|axis| axis.staged).collect(), now);
                    Expect { no: start.no | why, ..start }
                }
            },
            Line::Zero(n) if usize::from(n) <= self.tracks.len() => {
                Expect::idle(self.busy(1 << (n - 1), now))
            }
            Line::Position(n) => match self.tracks.get(usize::from(n) - 1) {
                Some(track) => Expect::unless(track.known.not(), Reason::Uncertain),
                None => axis(n),
            },
            Line::Zero(n) | Line::Select(n) => axis(n),
            Line::Set(..) | Line::Reset => Expect::idle(self.busy(u8::MAX, now)),
            Line::Status
            | Line::Brake
            | Line::Kill
            | Line::Info
            | Line::Clear
            | Line::Lease(_)
            | Line::All
            | Line::Get(_) => Expect::YES,
        }
    }

    /// Whether these travels may start.
    fn start(&self, travels: Vec<Option<Travel>>, now: u64) -> Expect {
        if travels.iter().all(Option::is_none) {
            return Expect::no(Reason::NoTravel);
        }
        let mut expect = Expect::YES;
        let mut fresh = Vec::new();
        for (n, travel) in travels.into_iter().enumerate() {
            let Some(travel) = travel else { continue };
            let manner = &self.slave.axes[n];
            let limits = manner.limits();
            expect = expect.and(Expect::idle(self.tracks[n].busy(now, self.measure())));
            expect = expect.and(manner.allowed(&self.settings));
            expect = expect.and(self.slow(&limits));
            expect = expect.and(self.stopped()).and(self.admit(n, travel));
            let (steps, most_steps) = self.steps(n, travel);
            let endless = most_steps.is_infinite();
            expect.no = expect.no | self.reason(limits.is_gentle(endless), Reason::TooGentle);
            if travel != Travel::By(0) {
                expect = expect
                    .and(Expect::unless(self.blocked(n, travel.forward(), now), Reason::Fault));
                // An axis that makes only one step delays the others too.
                let most = Limits { jerk: f64::INFINITY, ..limits }.peak(most_steps);
                fresh.push((n, limits.peak(steps), most));
            }
        }
        expect.and(self.fast(&fresh, now))
    }

    /// Whether a change by m (or t), a or d is allowed during a travel.
    fn change(&self, letter: u8, number: u32, now: u64) -> Expect {
        let (limit, why) = match letter {
            b'm' => (settings::MAX_SPEED, Reason::TooFast),
            _ => (settings::MAX_ACCEL, Reason::Ramp),
        };
        let mut expect = Expect::YES;
        let mut faster = Vec::new();
        for (n, track) in
            self.tracks.iter().enumerate().filter(|(n, _)| self.slave.selected >> n & 1 != 0)
        {
            let busy = track.busy(now, self.measure());
            if busy == Known::No {
                continue;
            }
            // The axis may come to rest while the board works on the line.
            expect.no = expect.no | self.reason(busy == Known::Maybe, Reason::NoTravel);
            if letter == b'd' {
                expect = expect.and(self.admit_decel(n, busy));
            }
            let limits = changed(track.limits, letter, number);
            let below = letter == b'm' && limits.top < track.limits.start;
            let unit = if letter == b'm' { 1000 } else { 1 };
            let over = u64::from(number) > u64::from(self.settings.get(limit)) * unit;
            let bad = |bad: bool| match (bad, busy) {
                (false, _) => Known::No,
                (true, Known::Yes) => Known::Yes,
                _ => Known::Maybe,
            };
            expect = expect.and(Expect::unless(bad(below), Reason::TooSlow));
            expect = expect.and(Expect::unless(bad(over), why));
            let slow = self.slow(&limits);
            expect.no = expect.no | slow.no;
            let none = limits.top > limits.start && limits.up.max(limits.down).is_infinite();
            expect = expect.and(Expect::unless(bad(none), Reason::TooGentle));
            expect.no = expect.no | self.gentle(track, limits);
            let far =
                matches!(track.goal, Goal::End(end, _) if (end - track.origin).abs() > 1 << 30);
            expect.no = expect.no | self.reason(far, Reason::Travel);
            faster.push((n, limits.top, limits.top.max(track.highest)));
        }
        // A short way may not reach the top speed: the board may refuse it, but need not.
        expect.no = expect.no | self.fast(&faster, now).no;
        expect
    }

    /// Whether the ramps of a travel in progress may be too gentle with these limits. The travel may be
    /// faster than its top speed, and has to lose that too.
    fn gentle(&self, track: &Track, limits: Limits) -> Reasons {
        let ramps = Limits { top: limits.top.max(track.highest), ..limits };
        self.reason(ramps.is_gentle(true), Reason::TooGentle)
    }

    /// Whether `@` is allowed during a travel.
    fn retarget(&self, steps: i64, now: u64) -> Expect {
        let mut expect = Expect::YES;
        let mut faster = Vec::new();
        for (n, track) in
            self.tracks.iter().enumerate().filter(|(n, _)| self.slave.selected >> n & 1 != 0)
        {
            let rests = track.busy(now, self.measure()).not();
            expect = expect.and(Expect::unless(rests, Reason::NoTravel));
            expect = expect.and(self.admit_target(n, steps));
            for forward in [false, true] {
                let blocked = self.blocked(n, forward, now) != Known::No;
                expect.no = expect.no | self.reason(blocked, Reason::Fault);
            }
            let far = steps.abs() > 1 << 30 || (track.count - track.origin).abs() > 1 << 30;
            expect.no = expect.no | self.reason(far, Reason::Travel);
            expect.no = expect.no | self.gentle(track, track.limits);
            faster.push((n, track.limits.top, track.highest));
        }
        expect.no = expect.no | self.fast(&faster, now).no;
        expect
    }

    /// Applies a line that was answered Y.
    pub(crate) fn obey(&mut self, line: Line, now: u64) -> Result<(), Fault> {
        let selected = self.slave.selected;
        let measure = *self.measure();
        match line {
            Line::Program => {
                self.settle(selected, now)?;
                let slave = &mut self.slave;
                slave.forget();
                slave.axes.iter_mut().for_each(|axis| axis.jerk = 0);
                // An active input spoils the order the next moment.
                slave.order = match self.guard.is_stopping() {
                    true => Open::Doubted(Reason::Fault.into()),
                    false => Open::Yes,
                };
                if slave.naming == Naming::Said && slave.selected != 1 {
                    (slave.naming, slave.selected) = (Naming::Unclear, slave.selected | 1);
                } else {
                    (slave.naming, slave.selected) = (Naming::Used, 1);
                }
            }
            Line::Manner(letter, number) => self.manner(letter, number, now)?,
            Line::Go(steps) => {
                self.settle(selected, now)?;
                self.slave.chosen().for_each(|axis| axis.staged = Some(Travel::By(steps)));
            }
            Line::Run(forward) => {
                self.settle(selected, now)?;
                self.slave.chosen().for_each(|axis| axis.staged = Some(Travel::Endless(forward)));
                if self.slave.order == Open::No {
                    self.go(now)?;
                }
            }
            Line::Execute => self.go(now)?,
            Line::Retarget(steps) => {
                for track in self.tracks.iter_mut().filter(|track| selected >> track.axis & 1 != 0)
                {
                    (track.stops, track.bounded) = (Stops::NONE, Known::No);
                    track.retarget(now, steps, &measure);
                }
            }
            Line::Brake => {
                for track in self.tracks.iter_mut().filter(|track| selected >> track.axis & 1 != 0)
                {
                    let busy = track.busy(now, &measure);
                    track.stops.soft(b'Z', busy);
                    track.brake(now, &measure);
                }
            }
            Line::Kill => {
                self.ordered = Some(now);
                self.guard.note(b'K', Known::Yes);
                if self.settings.get(settings::KILL_OFF) != 0 {
                    self.guard.off = Some(now);
                }
                for track in &mut self.tracks {
                    let busy = track.busy(now, &measure);
                    track.stops.hard(b'K', busy);
                    match busy {
                        Known::No => {}
                        // An axis that has not made a step may keep its known position. So may an axis that
                        // rests before it turns during a travel.
                        Known::Yes if !track.is_fresh() && !track.may_turn(&measure) => {
                            track.known = Known::No;
                        }
                        _ if track.known == Known::Yes => track.known = Known::Maybe,
                        _ => {}
                    }
                    track.halt();
                }
                self.slave.spoil(Reason::Killed.into());
            }
            Line::Zero(n) => {
                self.settle(1 << (n - 1), now)?;
                let track = &mut self.tracks[usize::from(n) - 1];
                (track.zero, track.known) = (track.count, Known::Yes);
            }
            Line::Select(n) => {
                self.slave.selected = if n == 0 { u8::MAX } else { 1 << (n - 1) };
                self.slave.naming = Naming::Said;
            }
            Line::Clear => {
                (self.slave.refusals, self.slave.last) = (0, None);
                self.guard.clear(now);
                for track in &mut self.tracks {
                    track.stops = Stops::NONE;
                    // An axis that an active input stops may have rested before.
                    if track.doomed == Known::Yes {
                        track.doomed = Known::Maybe;
                    }
                    track.bounded = match (track.bounded, track.busy(now, &measure)) {
                        (bounded, Known::Yes) => bounded,
                        (Known::No, _) | (_, Known::No) => Known::No,
                        _ => Known::Maybe,
                    };
                }
            }
            Line::Lease(millis) => {
                self.guard.lease = (millis, if millis == 0 { Known::No } else { Known::Yes });
            }
            Line::Set(name, number) => {
                self.settle(u8::MAX, now)?;
                self.settings.set(name, number);
                self.store(now);
                self.set_up(now);
            }
            Line::Reset => {
                self.settle(u8::MAX, now)?;
                self.settings = Settings::new(self.board().can);
                self.store(now);
                self.set_up(now);
            }
            Line::Status | Line::Position(_) | Line::Info | Line::All | Line::Get(_) => {}
        }
        Ok(())
    }

    /// Applies S, T, R, s, t, a, d or j.
    fn manner(&mut self, letter: u8, number: u32, now: u64) -> Result<(), Fault> {
        let selected = self.slave.selected;
        let measure = *self.measure();
        if matches!(letter, b'm' | b'a' | b'd') && self.slave.order == Open::No {
            for track in self.tracks.iter_mut().filter(|track| selected >> track.axis & 1 != 0) {
                if track.busy(now, &measure) != Known::No {
                    let limits = changed(track.limits, letter, number);
                    track.limit(now, limits, &measure);
                }
            }
        } else {
            self.settle(selected, now)?;
        }
        for axis in self.slave.chosen() {
            match letter {
                b'S' => axis.start = number * 10,
                b'T' => axis.top = number * 10_000,
                b's' => axis.start = number,
                b'm' => axis.top = number,
                b'a' => axis.up = number,
                b'd' => axis.down = number,
                b'j' => axis.jerk = number,
                _ => (axis.ramp, axis.up, axis.down) = (number, 0, 0),
            }
        }
        Ok(())
    }

    /// Starts all staged travels.
    fn go(&mut self, now: u64) -> Result<(), Fault> {
        let measure = *self.measure();
        let staged: Vec<_> = self.slave.axes.iter().map(|axis| axis.staged).collect();
        let moves = |travel: &Option<Travel>| travel.is_some_and(|travel| travel != Travel::By(0));
        let (not_before, wait) = self.drivers(now);
        (self.ordered, self.guard.off) = (Some(now), None);
        // The travels start together after all axes have rested.
        let rests: f64 = self.tracks.iter().map(Track::longest_rest).sum();
        let rests = (rests * measure.hz).min(1e18) as u64;
        self.moved =
            if staged.iter().any(moves) { Known::Yes } else { self.moved.or(Known::Maybe) };
        for (n, travel) in staged.iter().enumerate() {
            let Some(travel) = *travel else { continue };
            self.settle(1 << n, now)?;
            let limits = self.slave.axes[n].limits();
            self.slave.axes[n].travel = limits;
            self.tracks[n].stops = Stops::NONE;
            let steps = match self.fence(n, travel) {
                Travel::By(0) => continue,
                Travel::By(steps) => Some(steps),
                Travel::Endless(_) => None,
            };
            let track = &mut self.tracks[n];
            track.order(limits);
            track.not_before = not_before;
            let wait = wait + rests + measure.setup + 2 * measure.hold;
            track.begin(now, steps, travel.forward(), wait, &measure);
            if track.bounded == Known::Maybe {
                track.goal = Goal::Open;
            }
        }
        self.slave.forget();
        if self.slave.order != Open::No {
            self.slave.naming = Naming::Used;
        }
        self.slave.order = Open::No;
        Ok(())
    }
}

/// The limits after m, a or d.
fn changed(limits: Limits, letter: u8, number: u32) -> Limits {
    let number = f64::from(number);
    match letter {
        b'm' => Limits { top: number / 1000.0, ..limits },
        b'a' => Limits { up: number, ..limits },
        _ => Limits { down: number, ..limits },
    }
}
