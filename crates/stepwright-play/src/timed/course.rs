//! Plays an order on the virtual board, from the call on.

use std::str::FromStr;

use stepwright_sim::timed::{Change, TimedBoard};
use stepwright_timed::fit::{Fitted, Hardware};
use stepwright_timed::{Call, Code, Control, Dump, Model, Status};

use super::{TimedOrder, TimedWiring};
use crate::PlayError;

/// The most steps that are kept.
const MOST: usize = 20_000_000;

/// When to print the debug dump, in ms after the call.
#[derive(Clone, Debug)]
pub enum Moments {
    /// At these times.
    Each(Vec<f64>),
    /// The first time, and the interval.
    Every(f64, f64),
}

impl FromStr for Moments {
    type Err = String;

    fn from_str(text: &str) -> Result<Moments, String> {
        let number = |text: &str| match text.trim().parse::<f64>() {
            Ok(ms) if (0.0..=1e8).contains(&ms) => Ok(ms),
            _ => Err(format!("{text:?} is no time in ms")),
        };
        if let Some((first, every)) = text.split_once('+') {
            return match (number(first)?, number(every)?) {
                (_, every) if every < 1.0 => Err("a ms at least from one to the next".into()),
                (first, every) => Ok(Moments::Every(first, every)),
            };
        }
        let mut each = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
        each.sort_by(f64::total_cmp);
        Ok(Moments::Each(each))
    }
}

impl Moments {
    /// The nth time, counted from 0.
    pub fn at(&self, n: usize) -> Option<f64> {
        match self {
            Moments::Each(each) => each.get(n).copied(),
            Moments::Every(first, every) => Some(first + every * n as f64),
        }
    }
}

/// The order to play, and its options.
pub struct TimedPlay<'a> {
    /// The timer.
    pub hardware: Hardware,
    /// Whether a new top waits in the compare register, as in fast PWM.
    pub latched: bool,
    /// The order.
    pub order: &'a TimedOrder,
    /// The wiring of the motor.
    pub wiring: &'a TimedWiring,
    /// How long to watch, in ms from the call; by default until the end.
    pub for_ms: Option<u32>,
    /// When to print the debug dump.
    pub log: Option<&'a Moments>,
}

/// The result of an order.
pub struct TimedCourse<'a> {
    /// The timer.
    pub hardware: Hardware,
    /// Whether a new top waits in the compare register, as in fast PWM.
    pub latched: bool,
    /// The order.
    pub order: &'a TimedOrder,
    /// The driver's answer.
    pub code: Code,
    /// The speeds in the order of time.
    pub updates: Vec<SpeedUpdate>,
    /// The debug dumps.
    pub dumps: Vec<LoggedDump>,
    /// The callbacks, with their ms after the call.
    pub calls: Vec<(f64, Call)>,
    /// The status at the end.
    pub status: Status,
    /// The number of steps made, if known.
    pub made: Option<u64>,
    /// The clock of each step; empty for a real board.
    pub steps: Vec<u64>,
    /// Whether a real board has carried out the order.
    pub on_board: bool,
    /// The changes of the pins.
    pub changes: Vec<Change>,
    /// The phase before the first step.
    pub phase: u8,
    /// The number of rows of the motor's pattern.
    pub rows: u8,
    /// The end of the watching in clocks, and whether the motor still moved then.
    pub end: u64,
    /// Whether the motor still moves then.
    pub moving: bool,
}

impl TimedPlay<'_> {
    /// The longest time to watch an order, in ms from the call.
    pub fn until_ms(&self) -> Option<u32> {
        let set_speed = &self.order.set_speed;
        let variable = set_speed.control.has(Control::SPEED_VARIABLE);
        let updates = if variable { u32::from(set_speed.mod_counts) } else { 0 };
        let watched = 2_000 + updates.saturating_mul(set_speed.update_ms.into());
        self.for_ms.or((set_speed.limit == 0).then_some(watched))
    }
}

/// The failure for an order that the driver refused.
pub fn refused(code: Code) -> PlayError {
    let text = code.to_string();
    let (what, todo) = text.split_once("; ").unwrap_or((&text, "see --help"));
    PlayError::new(what).hint(todo)
}

/// The speed from this clock on; the first one is the call's.
pub struct SpeedUpdate {
    /// The clock from which it counts.
    pub clock: u64,
    /// Steps made by then.
    pub steps: usize,
    /// The virtual top.
    pub top: u32,
    /// The modification.
    pub modification: u32,
    /// The interval on the timer.
    pub fitted: Fitted,
}

/// A dump and its ms after the call.
pub struct LoggedDump {
    /// The time of the dump in ms.
    pub ms: f64,
    /// The dump.
    pub dump: Dump,
}

impl<'a> TimedCourse<'a> {
    /// Plays an order.
    pub fn play(play: &TimedPlay<'a>) -> Result<TimedCourse<'a>, PlayError> {
        let TimedPlay { hardware, latched, order, wiring, .. } = *play;
        let model = if latched { Model::Latched } else { Model::Ideal };
        let mut board = TimedBoard::new(hardware, model, wiring.sequence, order.call_ms());
        board.restore(wiring.phase);
        let code = board.set_speed(&order.set_speed);
        if code.is_error() {
            return Err(refused(code));
        }
        let mut course = TimedCourse::begin(play, code, wiring.phase, wiring.sequence.len());
        course.on_board = false;
        course.note(&mut board);
        course.watch(&mut board, play)?;
        course.status = board.status();
        course.moving = board.is_moving();
        course.end = board.now();
        course.steps = board.steps().to_vec();
        course.made = Some(course.steps.len() as u64);
        course.changes = board.changes().to_vec();
        Ok(course)
    }

    /// The course of an order that a board has accepted with this code.
    pub fn begin(play: &TimedPlay<'a>, code: Code, phase: u8, rows: u8) -> TimedCourse<'a> {
        TimedCourse {
            hardware: play.hardware,
            latched: play.latched,
            order: play.order,
            code,
            updates: Vec::new(),
            dumps: Vec::new(),
            calls: Vec::new(),
            status: Status::NONE,
            made: None,
            steps: Vec::new(),
            on_board: true,
            changes: Vec::new(),
            phase,
            rows,
            end: 0,
            moving: true,
        }
    }

    /// Lets the board run: carries out events, checks and dumps in the order of time.
    fn watch(&mut self, board: &mut TimedBoard, play: &TimedPlay) -> Result<(), PlayError> {
        let until = play.until_ms().map_or(u64::MAX, |ms| board.clocks(ms.into()));
        let mut check = self.order.poll_ms.map(|ms| (ms, ms));
        let mut logged = 0;
        loop {
            let dump = play.log.and_then(|log| log.at(logged)).map(|ms| (board.clocks(ms), ms));
            let polled = check.map(|(at, _)| board.clocks(at.into()));
            let event = board.due();
            // Once the motor is at rest, a last check may still call back. All dumps of an explicit
            // list are made.
            let asked = matches!(play.log, Some(Moments::Each(_)));
            let called = self.calls.iter().any(|(_, call)| *call == Call::Reached);
            let waits = polled.is_some() && !called;
            let quiet = event.is_none() && !waits && play.for_ms.is_none();
            let times = [
                event,
                polled.filter(|_| !quiet),
                dump.map(|(at, _)| at).filter(|_| !quiet || asked),
            ];
            let Some(next) = times.into_iter().flatten().min().filter(|at| *at <= until) else {
                break;
            };
            board.run_until(next);
            if polled == Some(next) {
                let ms = self.ms(next);
                let calls = &mut self.calls;
                board.update_check(|call| calls.push((ms, call)));
                check = check.map(|(at, every)| (at.saturating_add(every), every));
            }
            self.note(board);
            if let Some((_, ms)) = dump.filter(|(at, _)| *at == next) {
                self.dumps.push(LoggedDump { ms, dump: board.dump() });
                logged += 1;
            }
            if board.steps().len() > MOST {
                return Err(PlayError::new(format!("more than {MOST} steps"))
                    .hint("watch it for a shorter time: --for-ms 10000"));
            }
        }
        if until != u64::MAX {
            board.run_until(until);
        }
        Ok(())
    }

    /// Records an update.
    fn note(&mut self, board: &mut TimedBoard) {
        let dump = board.dump();
        if self.updates.last().is_some_and(|last| last.top == dump.top) {
            return;
        }
        if let Ok(fitted) = self.hardware.fit(dump.top) {
            let Dump { top, modification, .. } = dump;
            let (clock, steps) = (board.now(), board.steps().len());
            self.updates.push(SpeedUpdate { clock, steps, top, modification, fitted });
        }
    }

    /// Converts clocks to milliseconds.
    pub fn ms(&self, clock: u64) -> f64 {
        clock as f64 * 1e3 / f64::from(self.hardware.hz())
    }

    /// Converts a speed to turns per minute.
    pub fn rpm(&self, speed: f64) -> f64 {
        speed * 60.0 / f64::from(self.order.steps_per_turn)
    }

    /// Number, clock, delay, speed and phase of each step.
    pub fn rows(&self) -> impl Iterator<Item = CourseStep> + '_ {
        let hz = f64::from(self.hardware.hz());
        let forward = !self.order.set_speed.control.has(Control::DIRECTION);
        let mut before = 0;
        self.steps.iter().zip(1u64..).map(move |(&clock, step)| {
            let delay = clock - std::mem::replace(&mut before, clock);
            let turned = (step % u64::from(self.rows)) as u8;
            let back = self.rows - turned;
            let phase = (self.phase + if forward { turned } else { back }) % self.rows;
            CourseStep { step, clock, delay, speed: hz / delay as f64, phase }
        })
    }
}

/// A step.
pub struct CourseStep {
    /// Its number, from 1.
    pub step: u64,
    /// The clock from which it counts.
    pub clock: u64,
    /// The clocks since the step before, or the call.
    pub delay: u64,
    /// The speed of this delay in steps/s.
    pub speed: f64,
    /// The row to begin at.
    pub phase: u8,
}
