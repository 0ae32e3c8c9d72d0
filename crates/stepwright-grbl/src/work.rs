//! A line in execution: carries out its effects one after another, each as soon as possible.

use std::collections::VecDeque;

use stepwright_gcode::{Block, Effect, Move, MoveKind, Parameter, Probe, Spindle, Stop};

use crate::machine::GrblMachine;
use crate::motion::Travel;
use crate::overrides::Overrides;
use crate::session::Grbl;
use crate::state::{After, State};
use stepwright_path::{ArcSweep, decimal, mm};

/// The remaining effects of a line, and the answer after them.
#[derive(Clone, Debug)]
pub(crate) struct Work {
    effects: VecDeque<Effect>,
    line: Option<u32>,
    jog: bool,
    /// The end of the present dwell.
    rests: Option<f64>,
    answer: Answer,
}

/// The answer at the end of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    Ok,
    /// For a start-up line, 0 or 1; `ok` follows if it came after homing.
    Startup {
        which: usize,
        home: bool,
    },
    /// For homing; start-up lines follow.
    Home,
}

/// A probing move in progress.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probing {
    pub probe: Probe,
}

/// The result of an effect.
enum Progress {
    Done,
    /// It must wait, and is tried again.
    Waits,
    /// It has caused an alarm: its line gets no answer.
    Given,
}

impl<M: GrblMachine> Grbl<M> {
    /// Executes a line of G-code, without blanks and comments.
    pub(crate) fn gcode(&mut self, text: &[u8]) {
        match self.read(text) {
            Ok(block) => self.begin(block, false, Answer::Ok),
            Err(number) => self.refuse(number),
        }
    }

    /// Parses a line. A line that can't be executed here is an error, and changes no mode.
    pub(crate) fn read(&mut self, text: &[u8]) -> Result<Block, u8> {
        let was = self.reader;
        let block = text.iter().chain(b"\n").find_map(|byte| self.reader.push(*byte));
        // The end of a line always gives a block.
        let block = block.unwrap_or(Ok(Block::default())).map_err(|error| error.fault.number())?;
        let probes = |effect| matches!(effect, Effect::Move(part) if is_probe(&part));
        if self.motion.fed && block.effects().any(probes) {
            self.reader = was;
            return Err(20);
        }
        Ok(block)
    }

    fn begin(&mut self, block: Block, jog: bool, answer: Answer) {
        let checks = self.state == State::Check;
        let effects = block.effects().filter(|_| !checks).collect();
        self.work = Some(Work { effects, line: block.number, jog, rests: None, answer });
    }

    /// Executes the rest of a line after `$J=`. It must have a feed rate, and only words of a jog.
    pub(crate) fn jog(&mut self, text: &[u8]) {
        if !matches!(self.state, State::Idle | State::Jog) {
            return self.error(8);
        }
        let was = self.reader;
        let modes: &[u8] = if was.modal().inverse_time { b"G94G1" } else { b"G1" };
        let line: Vec<u8> = modes.iter().chain(text).copied().collect();
        let read = if is_jog(text) { self.read(&line) } else { Err(16) };
        let after = self.reader.position();
        self.reader = was;
        let block = match read {
            Ok(_) if !text.contains(&b'F') => return self.error(22),
            Ok(block) => block,
            Err(number) => return self.error(number),
        };
        let outside = |effect| matches!(effect, Effect::Move(part) if !self.is_within(&part));
        let moves = block.effects().filter_map(|effect| match effect {
            Effect::Move(part) => Some(part),
            _ => None,
        });
        if block.effects().any(outside) || !moves.into_iter().all(|part| self.is_playable(&part)) {
            return self.error(15);
        }
        self.reader.set_position(after);
        self.begin(block, true, Answer::Ok);
    }

    /// Begins the start-up lines, as after a reset.
    pub(crate) fn begin_startup(&mut self) {
        self.go_on_with_startup(0, false);
    }

    fn go_on_with_startup(&mut self, from: usize, home: bool) {
        for which in from..self.startup.len() {
            let text = self.startup[which].clone();
            if text.is_empty() {
                continue;
            }
            match self.read(text.as_bytes()) {
                Ok(block) => return self.begin(block, false, Answer::Startup { which, home }),
                Err(number) => self.say(&format!(">{text}:error:{number}\r\n")),
            }
        }
        if home {
            self.ok();
        }
    }

    /// Sets up the answer to a homing that has begun, for its end.
    pub(crate) fn begin_homing_work(&mut self) {
        let effects = VecDeque::new();
        self.work =
            Some(Work { effects, line: None, jog: false, rests: None, answer: Answer::Home });
    }

    /// Carries out as many effects of the line as possible. Returns whether the line is done.
    pub(crate) fn go_on_with_work(&mut self) -> bool {
        if self.homing.is_some() {
            return false;
        }
        loop {
            let Some(work) = &self.work else { return true };
            let (effect, line, jog) = (work.effects.front().copied(), work.line, work.jog);
            let Some(effect) = effect else { break };
            match self.happen(effect, line, jog) {
                Progress::Waits => return false,
                Progress::Given => return true,
                Progress::Done => {}
            }
            if let Some(work) = &mut self.work {
                work.effects.pop_front();
            }
            if self.state == State::Hold {
                // M0: the rest of the line comes after it.
                return false;
            }
        }
        match self.work.take().map(|work| work.answer) {
            Some(Answer::Ok) => self.ok(),
            Some(Answer::Home) => self.go_on_with_startup(0, true),
            Some(Answer::Startup { which, home }) => {
                let said = format!(">{}:ok\r\n", self.startup[which]);
                self.say(&said);
                self.go_on_with_startup(which + 1, home);
            }
            None => {}
        }
        true
    }

    fn happen(&mut self, effect: Effect, line: Option<u32>, jog: bool) -> Progress {
        match effect {
            Effect::Tool(_) | Effect::Stop(Stop::OptionalPause) => return Progress::Done,
            Effect::Move(part) => return self.travel(&part, line, jog),
            Effect::Spindle(spindle) if self.settings.is_on(32) => {
                self.spindle = spindle;
                self.switch();
                return Progress::Done;
            }
            Effect::Parameter(parameter, _) => {
                self.seldom.offsets = 0;
                // Parameters that are kept are written at rest.
                if matches!(parameter, Parameter::G92 | Parameter::ToolLength) {
                    return Progress::Done;
                }
            }
            _ => {}
        }
        if !self.motion.is_over() {
            return Progress::Waits;
        }
        match effect {
            Effect::Spindle(spindle) => self.spin(spindle),
            Effect::Coolant(coolant) => self.cool(coolant),
            Effect::Dwell(seconds) => return self.dwell(decimal(seconds)),
            Effect::Stop(Stop::Pause) => self.state = State::Hold,
            Effect::Stop(_) => {
                self.overrides = Overrides::NONE;
                self.seldom = Default::default();
                self.say("[MSG:Pgm End]\r\n");
            }
            _ => {}
        }
        Progress::Done
    }

    fn spin(&mut self, spindle: Spindle) {
        self.spindle = spindle;
        self.seldom.overrides = 0;
        self.switch();
    }

    fn dwell(&mut self, seconds: f64) -> Progress {
        let now = self.now;
        let Some(work) = &mut self.work else { return Progress::Done };
        if now < *work.rests.get_or_insert(now + seconds) {
            return Progress::Waits;
        }
        work.rests = None;
        Progress::Done
    }

    /// Whether a move stays within the travel of the axes, or soft limits are off. The sides of an
    /// arc may exceed the travel by half a step, which no motor makes.
    fn is_within(&self, part: &Move) -> bool {
        if !self.settings.is_on(20) {
            return true;
        }
        let (travel, steps) = (self.settings.axes(130), self.settings.axes(100));
        let beyond = |axis: usize, at: f64| (-travel[axis] - at).max(at);
        let ends = (0..3).all(|axis| beyond(axis, mm(part.to.0[axis])) <= 0.0);
        let bulges = |(axis, at)| beyond(axis, at) > 0.5 / steps[axis];
        match part.kind {
            MoveKind::Arc(arc, _) => ends && !ArcSweep::of(part, arc).sides().any(bulges),
            _ => ends,
        }
    }

    fn travel(&mut self, part: &Move, line: Option<u32>, jog: bool) -> Progress {
        if let MoveKind::Probe(probe, _) = part.kind {
            return self.probe(part, probe, line);
        }
        let within = self.is_within(part);
        if within && self.motion.room() == 0 {
            return Progress::Waits;
        }
        if !(within && self.is_playable(part)) {
            self.brake(After::Alarm(2));
            return Progress::Given;
        }
        self.add(part, line, if jog { State::Jog } else { State::Run })
    }

    fn add(&mut self, part: &Move, line: Option<u32>, state: State) -> Progress {
        let tolerance = mm(self.reader.modal().tolerance);
        let travel = Travel { part: *part, line, spindle: self.spindle, tolerance };
        let scales = self.overrides.scales(state == State::Jog || is_probe(part));
        match self.motion.add(self.now, &self.settings, scales, &travel) {
            Ok(()) => {
                if !self.motion.is_over() {
                    self.state = state;
                }
                Progress::Done
            }
            // More than 2³¹ steps, or a speed that no machine has.
            Err(_) => {
                self.brake(After::Alarm(2));
                Progress::Given
            }
        }
    }

    /// Moves until the probe gains or loses contact.
    fn probe(&mut self, part: &Move, probe: Probe, line: Option<u32>) -> Progress {
        if !self.motion.is_over() {
            return Progress::Waits;
        }
        if self.probing.take().is_some() {
            // The probing move has ended.
            self.find_place();
            if !self.probe_met {
                self.probe_at = self.place();
                if probe.must {
                    self.brake(After::Alarm(5));
                    self.probed();
                    self.ok();
                    return Progress::Given;
                }
            }
            self.probed();
            self.settle();
            return Progress::Done;
        }
        self.probe_met = false;
        if self.machine.inputs().probe == probe.toward {
            self.brake(After::Alarm(4));
            self.ok();
            return Progress::Given;
        }
        if !self.is_within(part) || !self.is_playable(part) {
            self.brake(After::Alarm(2));
            return Progress::Given;
        }
        match self.add(part, line, State::Run) {
            Progress::Done => {
                self.probing = Some(Probing { probe });
                Progress::Waits
            }
            other => other,
        }
    }
}

const fn is_probe(part: &Move) -> bool {
    matches!(part.kind, MoveKind::Probe(..))
}

/// Whether a line has only words of a jog: F, N, axes, G20, G21, G53, G90, G91.
fn is_jog(text: &[u8]) -> bool {
    let mut bytes = text.iter().peekable();
    while let Some(letter) = bytes.next() {
        let mut number = Vec::new();
        while let Some(byte) = bytes.next_if(|byte| !byte.is_ascii_alphabetic()) {
            number.push(*byte);
        }
        let good = match letter {
            b'F' | b'N' | b'X' | b'Y' | b'Z' => true,
            b'G' => [&b"20"[..], b"21", b"53", b"90", b"91"].contains(&&number[..]),
            // Text that does not begin with a letter is not a word; the reader refuses it.
            _ => !letter.is_ascii_alphabetic(),
        };
        if !good {
            return false;
        }
    }
    true
}
