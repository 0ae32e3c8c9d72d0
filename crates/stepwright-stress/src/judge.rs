//! The judge. It takes bytes and edges in the order of time, and returns the first broken rule.

mod told;

use stepwright_sim::Edge;

use crate::fault::{Fault, Rule, Rules};
use crate::grammar::{self, Line};
use crate::guard::Guard;
use crate::reason::{Reason, Reasons};
use crate::settings::{self, Settings};
use crate::slave::{Expect, Slave};
use crate::story::{Board, Reset};
use crate::sum;
use crate::track::{Goal, Known, Measure, Track};

/// A line that has no answer yet.
#[derive(Clone, Debug)]
struct Asked {
    line: Result<Line, Reasons>,
    text: String,
    empty: bool,
    /// The time at which it was complete.
    since: u64,
    /// Whether the line has a checksum, or may have had one. Then its answer has one too.
    sum: bool,
    expect: Expect,
    /// The least and the greatest position of the requested axis so far.
    positions: (i64, i64),
}

/// The enable pin of the drivers around a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Enable {
    /// Its level before the line.
    pub before: bool,
    /// The time of its last change, as seen at the answer.
    pub since: u64,
}

/// Follows a conversation and knows what a board may do.
pub struct Judge {
    board: Board,
    measure: Measure,
    pub(crate) tracks: Vec<Track>,
    pub(crate) slave: Slave,
    pub(crate) settings: Settings,
    bytes: Vec<u8>,
    asked: Option<Asked>,
    /// When the answer to the last line began and ended. The silence begins between the two. And the state
    /// of the silence by the settings and by a lease.
    heard: (u64, u64),
    silent: [Silence; 2],
    /// Errors, leases, inputs.
    pub(crate) guard: Guard,
    /// Levels of the switches' pins.
    switches: [bool; 8],
    /// Per switch backward and forward: until when a switch that has opened counts as closed, and until
    /// when it may.
    held: [[(u64, u64); 2]; 8],
    /// The enable pin around the last line. A change counts as that of the line, or of its answer.
    enable: Option<Enable>,
    /// The settings that a loss of power may restore, and the time of the last change.
    stored: (Vec<Settings>, u64),
    /// The power came on: the judge has to learn the settings.
    unsure: bool,
    /// Whether a travel has begun since the power came on.
    pub(crate) moved: Known,
    /// The time at which the drivers that were switched on last are ready, by the `enable-ms` of that time.
    /// An order of no steps switches them on too.
    ready: u64,
    /// The time of the last order.
    pub(crate) ordered: Option<u64>,
    /// The number of answered lines.
    pub lines: u64,
}

/// The time in µs until settings are stored: two copies of 40 bytes, twice.
const KEPT: u32 = 600_000;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Silence {
    No,
    Perhaps,
    Obeyed,
}

impl Judge {
    /// The judge of a board at power-up.
    pub fn new(board: &Board, rules: Rules) -> Judge {
        let settings = Settings::new(board.can);
        let mut judge = Judge {
            board: *board,
            measure: Measure {
                hz: f64::from(board.hz),
                jitter: 0.0,
                // At least one tick: see docs/accuracy.md.
                fit: (f64::from(board.hz) * board.fit).max(1.0),
                pulse: 0,
                setup: 0,
                hold: 0,
                slack: board.slack,
                switch: board.ticks(2000),
                rules,
            },
            tracks: (0..board.axes).map(Track::new).collect(),
            slave: Slave::new(board.axes.into()),
            settings,
            bytes: Vec::new(),
            asked: None,
            heard: (0, 0),
            silent: [Silence::No; 2],
            guard: Guard::new(),
            switches: [true; 8],
            held: [[(0, 0); 2]; 8],
            enable: None,
            stored: (vec![Settings::new(board.can)], 0),
            unsure: false,
            moved: Known::No,
            ready: 0,
            ordered: None,
            lines: 0,
        };
        judge.set_up(0);
        judge
    }

    /// The tolerances and timing of the board.
    pub fn measure(&self) -> &Measure {
        &self.measure
    }

    /// Applies changed settings.
    pub(crate) fn set_up(&mut self, now: u64) {
        let ticks = |name| self.board.ticks(self.settings.get(name));
        let measure = &mut self.measure;
        measure.pulse = ticks(settings::PULSE);
        measure.setup = ticks(settings::SETUP);
        measure.hold = ticks(settings::HOLD);
        for (axis, track) in self.tracks.iter_mut().enumerate() {
            track.reverse = self.settings.has(settings::REVERSE, axis);
        }
        self.look_at_switches(now);
        // Other settings may have moved a held switch to the other end, or removed it.
        for sides in &mut self.held {
            let latest = sides.iter().map(|(_, latest)| *latest).max().unwrap_or(0);
            *sides = [(0, latest); 2];
        }
        // After a reset the settings have to be read first.
        if !self.unsure {
            self.look_at_inputs(now);
        }
    }

    fn look_at_switches(&mut self, now: u64) {
        // A switch that has opened counts as closed for `debounce-ms` if the board saw it closed. The board
        // looks at it every millisecond.
        let held = |since: u64| match self.settings.get(settings::DEBOUNCE) {
            0 => (0, 0),
            millis => {
                let seen = now > since + self.measure.switch;
                let surely = if seen { now + self.board.ticks(1000 * (millis - 1)) } else { 0 };
                (surely, now + self.board.ticks(1000 * millis + 3000))
            }
        };
        for (axis, track) in self.tracks.iter_mut().enumerate() {
            let forward = self.settings.has(settings::SWITCH_FORWARD, axis);
            let closed = self.settings.has(settings::SWITCHES, axis)
                && self.switches[axis] == self.settings.has(settings::SWITCH_HIGH, axis);
            for (side, since) in track.closed.iter_mut().enumerate() {
                match (closed && forward == (side == 1), *since) {
                    (true, None) => *since = Some(now),
                    (false, Some(from)) => {
                        *since = None;
                        self.held[axis][side] = held(from);
                    }
                    _ => {}
                }
            }
        }
    }

    /// Advances the time to `now` and applies what follows from that alone.
    pub(crate) fn advance(&mut self, now: u64) -> Result<(), Fault> {
        // Changes of switches and inputs were reported before. Axes that stand since then may have stopped
        // before a silence.
        self.obey_inputs(now);
        for (track, held) in self.tracks.iter_mut().zip(self.held) {
            for (side, since) in track.closed.into_iter().enumerate() {
                // The switch may stop the axis from the first moment on.
                let ahead =
                    if side == 1 { track.most > track.count } else { track.least < track.count };
                if (since.is_some() || now < held[side].1) && ahead && track.goal != Goal::Rest {
                    track.open(b'S');
                    self.guard.note(b'S', Known::Maybe);
                }
                if since.is_some_and(|since| now > since + self.measure.switch) {
                    let edge = if side == 1 { &mut track.most } else { &mut track.least };
                    *edge = track.count;
                }
            }
        }
        self.hear_silence(now);
        let due = |track: &Track| track.due(now, &self.measure);
        self.tracks.iter().map(due).fold(Ok(()), Result::and)
    }

    /// Makes moving axes brake if no line has come for the time limit. A board that is working out an
    /// answer has been spoken to.
    fn hear_silence(&mut self, now: u64) {
        let now = self.asked.as_ref().map_or(now, |asked| now.min(asked.since));
        let timeout = self.settings.get(settings::TIMEOUT);
        let limits = [(timeout, Known::Yes), self.guard.lease];
        for (which, (millis, holds)) in limits.into_iter().enumerate() {
            let micros = u64::from(millis) * 1000;
            if millis == 0 || holds == Known::No || self.silent[which] == Silence::Obeyed {
                continue;
            }
            let from = self.heard.0 + self.board.ticks_wide(micros.saturating_sub(1000));
            let until = self.heard.1 + self.board.ticks_wide(micros + 3000);
            if now >= from && self.silent[which] == Silence::No {
                self.silent[which] = Silence::Perhaps;
                if self.tracks.iter().any(|track| track.goal != Goal::Rest) {
                    self.guard.note(b'T', Known::Maybe);
                }
            }
            if self.silent[which] == Silence::Perhaps && now >= until {
                // A line before this time may have been in time or not: see `answer`.
                for track in &mut self.tracks {
                    match (track.busy(until, &self.measure), holds) {
                        (Known::Yes, Known::Yes) => {
                            self.guard.note(b'T', Known::Yes);
                            track.stops.soft(b'T', Known::Yes);
                            track.brake(until, &self.measure);
                        }
                        _ => track.open(b'T'),
                    }
                }
                self.silent[which] = Silence::Obeyed;
                if which == 1 {
                    // The next host may not know of the lease.
                    self.guard.lease = (0, Known::No);
                }
            }
        }
    }

    /// Judges an edge on a pin.
    ///
    /// # Errors
    /// The rule that it breaks.
    pub fn edge(&mut self, edge: Edge) -> Result<(), Fault> {
        self.advance(edge.time)?;
        let moving = self.moving(edge.axis);
        self.measure.jitter = self.board.jitter(self.measure.pulse, moving);
        let Some(track) = self.tracks.get_mut(usize::from(edge.axis)) else {
            // Power-up sets DIR even of an axis that is not connected.
            let what = || format!("there is no axis {}", edge.axis + 1);
            return if edge.is_step() { self.broken(Rule::Order, edge.time, what) } else { Ok(()) };
        };
        let judged = track.edge(edge, &self.measure);
        let at = track.count - track.zero;
        if let Some(asked) = &mut self.asked
            && let Ok(Line::Position(axis)) = asked.line
            && axis == edge.axis + 1
        {
            asked.positions = (asked.positions.0.min(at), asked.positions.1.max(at));
        }
        judged
    }

    /// The number of axes that may delay an edge of this axis, with itself: those that move, and those that
    /// rest but have stepped within its last two intervals.
    fn moving(&self, axis: u8) -> usize {
        let since = self.tracks.get(usize::from(axis)).and_then(Track::last_but_one);
        let beside = |track: &Track| {
            track.axis == axis
                || track.goal != Goal::Rest
                || since.is_some_and(|since| track.last().is_some_and(|last| last >= since))
        };
        self.tracks.iter().filter(|track| beside(track)).count()
    }

    /// Whether the drivers were on before the line.
    fn drivers_were_on(&self) -> bool {
        let on = self.settings.get(settings::ENABLE_HIGH) != 0;
        self.enable.is_some_and(|enable| enable.before == on)
    }

    /// Checks, with `kill-off`, that a stop at once leaves the drivers off. Seen before a line.
    fn look_at_drivers(&self, now: u64) -> Result<(), Fault> {
        match self.guard.off {
            // The level is from before the line's last byte.
            Some(off) if self.drivers_were_on() && now > off + 2 * u64::from(self.board.byte) => {
                self.broken(Rule::Driver, now, || format!("drivers are on, switched off at {off}"))
            }
            _ => Ok(()),
        }
    }

    pub(crate) fn broken(
        &self,
        rule: Rule,
        now: u64,
        what: impl FnOnce() -> String,
    ) -> Result<(), Fault> {
        self.measure.rules.broken(rule, now, what)
    }

    /// Takes a complete byte of the line. True if it asks for an answer.
    ///
    /// # Errors
    /// A rule that was broken before this time.
    pub fn byte(&mut self, byte: u8, now: u64) -> Result<bool, Fault> {
        match byte {
            b'\n' if self.bytes.is_empty() => {}
            b'\r' => {
                self.advance(now)?;
                let mut bytes = std::mem::take(&mut self.bytes);
                while bytes.last() == Some(&b'\n') {
                    bytes.pop();
                }
                let sum = bytes.contains(&b'*') && bytes.len() <= grammar::LONGEST + 3;
                let line = match if sum { sum::bare(&bytes) } else { Some(&bytes[..]) } {
                    Some(bare) => grammar::read(bare, self.board.can),
                    None => Err(Reason::Sum.into()),
                };
                let positions = match line {
                    Ok(Line::Position(axis)) => {
                        self.tracks.get(usize::from(axis) - 1).map(|t| t.count - t.zero)
                    }
                    _ => None,
                };
                self.asked = Some(Asked {
                    expect: Expect::default(),
                    sum,
                    empty: bytes.is_empty(),
                    since: now,
                    text: bytes.escape_ascii().to_string(),
                    positions: positions.map_or((0, 0), |at| (at, at)),
                    line,
                });
                return Ok(true);
            }
            _ => self.bytes.push(byte),
        }
        Ok(false)
    }

    /// Judges the answer to the last line without its CR, which began at `now` and ended at `ended`. `None`
    /// if there was no answer.
    ///
    /// # Errors
    /// The rule that it breaks.
    pub fn answer(
        &mut self,
        answer: Option<&[u8]>,
        (now, ended): (u64, u64),
        enable: Enable,
    ) -> Result<(), Fault> {
        self.advance(now)?;
        let Some(mut asked) = self.asked.take() else {
            return self.broken(Rule::Answer, now, || "an answer that nobody asked for".into());
        };
        if self.silent.contains(&Silence::Perhaps) {
            self.tracks.iter_mut().for_each(|track| track.open(b'T'));
        }
        if self.silent[1] == Silence::Perhaps {
            self.guard.lease.1 = Known::Maybe;
        }
        // A board plans after it switches the drivers on and before it answers.
        let switched = (asked.since..now).contains(&enable.since);
        self.enable = Some(Enable { since: if switched { enable.since } else { now }, ..enable });
        self.look_at_drivers(now)?;
        self.lines += 1;
        let Some(answer) = answer else {
            return self.broken(Rule::Answer, now, || format!("{:?} is not answered", asked.text));
        };
        let checked = if asked.sum { sum::bare(answer) } else { Some(answer) };
        let Some(answer) = checked else {
            let what =
                || format!("{:?} is answered {:?}", asked.text, answer.escape_ascii().to_string());
            return self.broken(Rule::Answer, now, what);
        };
        let answer = std::str::from_utf8(answer).unwrap_or("(binary)").to_owned();
        if matches!(asked.line, Err(why) if why == Reason::Sum.into()) {
            self.guard.note(b'c', Known::Yes);
        }
        asked.expect = match asked.line {
            Ok(line) => self.expect(line, now),
            Err(why) => Expect::no(why),
        };
        let result = match (asked.line, answer.as_str()) {
            (_, "E") => self.refused(&asked, now),
            (Ok(line), _) => self.accepted(line, &answer, &asked, now),
            (Err(_), _) => self.wrong(&asked, &answer, now),
        };
        (self.heard, self.silent) = ((now, ended.max(now)), [Silence::No; 2]);
        result
    }

    fn wrong(&self, asked: &Asked, answer: &str, now: u64) -> Result<(), Fault> {
        self.broken(Rule::Answer, now, || {
            format!("{:?} is answered {answer:?}; {:?}", asked.text, asked.expect)
        })
    }

    /// Judges the answer E.
    fn refused(&mut self, asked: &Asked, now: u64) -> Result<(), Fault> {
        if asked.expect.no.is_empty() {
            return self.wrong(asked, "E", now);
        }
        self.slave.refused(asked.line.ok(), asked.expect.no, asked.empty);
        if let Ok(Line::Position(axis)) = asked.line
            && let Some(track) = self.tracks.get_mut(usize::from(axis) - 1)
        {
            track.known = Known::No;
        }
        Ok(())
    }

    /// Judges an answer other than E.
    fn accepted(&mut self, line: Line, answer: &str, asked: &Asked, now: u64) -> Result<(), Fault> {
        if !asked.expect.yes {
            return self.wrong(asked, answer, now);
        }
        match line {
            Line::Status => return self.told(answer, asked, now),
            Line::Position(axis) => return self.stands(axis, answer, asked, now),
            Line::Info => return self.described(answer, now),
            Line::All | Line::Get(_) => return self.listed(line, answer, asked, now),
            _ if answer != "Y" => return self.wrong(asked, answer, now),
            _ => {}
        }
        self.obey(line, now)
    }

    /// Whether any of these axes is busy.
    pub(crate) fn busy(&self, axes: u8, now: u64) -> Known {
        let chosen = self.tracks.iter().filter(|track| axes >> track.axis & 1 != 0);
        chosen.fold(Known::No, |sum, track| sum.or(track.busy(now, &self.measure)))
    }

    /// Takes note that the board says that these axes rest.
    pub(crate) fn settle(&mut self, axes: u8, now: u64) -> Result<(), Fault> {
        let measure = self.measure;
        let chosen = self.tracks.iter_mut().filter(|track| axes >> track.axis & 1 != 0);
        chosen.map(|track| track.rest(now, &measure)).fold(Ok(()), Result::and)
    }

    /// Notes that settings changed. They are stored in the background, a byte in 3.4 ms: for a while a
    /// reset may find the old settings.
    pub(crate) fn store(&mut self, now: u64) {
        let (stored, since) = &mut self.stored;
        if now > *since + self.board.ticks(KEPT) {
            stored.drain(..stored.len().saturating_sub(1));
        }
        *since = now;
        stored.push(self.settings.clone());
    }

    /// Takes a change of a switch's pin.
    ///
    /// # Errors
    /// A rule that was broken before this time.
    pub fn switch(&mut self, axis: u8, high: bool, now: u64) -> Result<(), Fault> {
        self.advance(now)?;
        if let Some(level) = self.switches.get_mut(usize::from(axis)) {
            *level = high;
        }
        self.look_at_switches(now);
        Ok(())
    }

    /// Whether a closed switch refuses an order now. `Maybe` if it has just changed.
    pub(crate) fn blocked(&self, axis: usize, forward: bool, now: u64) -> Known {
        let side = usize::from(forward);
        match self.tracks.get(axis).and_then(|track| track.closed[side]) {
            None if now < self.held[axis][side].0 => Known::Yes,
            None if now < self.held[axis][side].1 => Known::Maybe,
            None => Known::No,
            Some(since) if now <= since + self.measure.switch => Known::Maybe,
            Some(_) => Known::Yes,
        }
    }

    /// Handles a reset of the board.
    ///
    /// # Errors
    /// A rule that was broken before this time.
    pub fn reset(&mut self, reset: Reset, now: u64) -> Result<(), Fault> {
        self.advance(now)?;
        let lost = match reset {
            Reset::Power => Known::No,
            Reset::Blink => self.busy(u8::MAX, now).or(self.stirring(now)),
            Reset::Button => self.moved,
            Reset::Watchdog => Known::Yes,
        };
        // A board without doubt begins as at power-up: at a known 0, and nothing has moved. A board in doubt
        // is still in doubt after the next button.
        self.moved = lost;
        self.ordered = None;
        self.slave = Slave::new(self.tracks.len());
        let known = lost.not();
        for track in &mut self.tracks {
            track.reset(known);
            track.stops.hard(b'R', lost);
        }
        self.bytes.clear();
        (self.asked, self.heard, self.silent) = (None, (now, now), [Silence::No; 2]);
        self.held = [[(0, 0); 2]; 8];
        self.guard.reset(lost);
        self.unsure = true;
        self.set_up(now);
        Ok(())
    }

    /// Whether the board may still report motion: it may do so for some milliseconds after a travel.
    fn stirring(&self, now: u64) -> Known {
        let last = self.tracks.iter().filter_map(Track::last).max();
        let recent = |since: u64| now < since.saturating_add(self.board.ticks(3000));
        let stirs = last.is_some_and(recent) || self.ordered.is_some_and(recent);
        if stirs { Known::Maybe } else { Known::No }
    }

    /// Whether the power came on and the settings have not been read since.
    pub fn is_unsure(&self) -> bool {
        self.unsure
    }

    /// The time from which the drivers take a step, and the most ticks from an order to its first step.
    pub(crate) fn drivers(&mut self, now: u64) -> (u64, u64) {
        let delay = self.board.ticks(1000 * self.settings.get(settings::ENABLE));
        let latest = self.tracks.iter().map(|track| track.not_before).max().unwrap_or(0);
        let since = self.enable.map_or(now, |enable| enable.since);
        let from = if self.drivers_were_on() {
            latest
        } else {
            self.ready = since + delay;
            self.ready
        };
        (from, delay.max(self.ready.saturating_sub(now)) + self.board.ticks(2000))
    }

    /// Whether an axis rests.
    pub(crate) fn rests(&self, axis: u8) -> bool {
        self.tracks.get(usize::from(axis)).is_some_and(|track| track.goal == Goal::Rest)
    }

    /// The board.
    pub(crate) fn board(&self) -> &Board {
        &self.board
    }

    /// The reason for a refusal that only motion decides, if `when`.
    pub(crate) fn reason(&self, when: bool, reason: Reason) -> Reasons {
        if when { reason.into() } else { Reasons::NONE }
    }
}
