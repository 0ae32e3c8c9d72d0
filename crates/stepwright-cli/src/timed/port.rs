//! `timed --port`: carries out the order on a board with the program `timed`, over its serial line.

use std::time::Duration;

use stepwright::drive::Arduino;
use stepwright_timed::fit::Hardware;
use stepwright_timed::line::{Line, NAME, Report, Unwired, Wire};
use stepwright_timed::{Call, Code, Control};

use crate::failure::Failure;
use crate::interrupt;
use crate::order::target;
use stepwright_host::Session;
use stepwright_host::link::Link;
use stepwright_host::programs::{RowProblem, TimedProblem, TimedSession};
use stepwright_play::timed::{LoggedDump, Moments, SpeedUpdate, TimedCourse, TimedPlay, refused};
use stepwright_protocol::Fault;

/// The longest time between two polls of the motor, in ms.
const LOOK: u32 = 100;

/// A board with the timed driver.
pub struct Board(TimedSession);

impl Board {
    /// Connects to the board on a link.
    pub fn meet(link: Box<dyn Link>) -> Result<Board, Failure> {
        // A signal ends the watching; the motor is stopped then.
        let mut session = Session::new(link);
        let name = session.name();
        let about = target::met_program(&mut session, NAME, |_| "timed")?;
        TimedSession::of(session, about).map(Board).map_err(|problem| failure(&name, problem))
    }

    /// The Arduino model; `None` if unknown.
    pub fn arduino(&self) -> Option<Arduino> {
        match self.0.board() {
            "uno" => Some(Arduino::Uno),
            "mega" => Some(Arduino::Mega),
            _ => None,
        }
    }

    /// Converts the problem of a row to a failure.
    fn heard<T>(&self, result: Result<T, TimedProblem>) -> Result<T, Failure> {
        result.map_err(|problem| failure(&self.0.name(), problem))
    }

    /// Sends a row that must be answered `Y`.
    fn say(&mut self, line: Line, what: &str) -> Result<(), Failure> {
        let said = self.0.say(&line);
        let Err(RowProblem::Refused { reason, .. }) = said else { return self.heard(said) };
        let refused = Failure::new(format!("{} refused {what}", self.0.name()));
        Err(refused.hint(match reason {
            Fault::Busy => "its motor moves: `stepwright timed 0 --port` stops it".to_owned(),
            Fault::Own(Unwired::Pins) => {
                "a motor is on pins of one port that the board has, other than those of the \
                 serial line"
                    .to_owned()
            }
            _ => format!("to {line}: {reason}"),
        }))
    }

    /// Checks that the board has a motor on this timer.
    fn has(&self, timer: u8) -> Result<(), Failure> {
        if self.0.timers().any(|has| has == timer) {
            return Ok(());
        }
        let all: Vec<_> = self.0.timers().map(|timer| timer.to_string()).collect();
        Err(Failure::usage(format!("a {} has no motor on timer {timer}", self.0.board()))
            .hint(format!("--on-timer is one of {}", all.join(", "))))
    }

    /// Stops a timer's motor.
    pub fn stop(&mut self, timer: u8) -> Result<(), Failure> {
        self.has(timer)?;
        let stopped = self.0.stop(timer);
        self.heard(stopped)
    }

    /// Carries out an order on a timer's motor, and stops the motor at the end.
    pub fn play<'a>(
        &mut self,
        play: &TimedPlay<'a>,
        timer: u8,
        wire: Wire,
    ) -> Result<TimedCourse<'a>, Failure> {
        let TimedPlay { hardware, latched, order, .. } = *play;
        self.has(timer)?;
        let hz = self.0.hz();
        if hardware != Hardware::avr16(hz) {
            return Err(Failure::usage(format!(
                "the timers of {} have 16 bits and run at {hz} Hz",
                self.0.name(),
            ))
            .hint("leave --timer and --clock out, or give those of the board"));
        }
        self.say(Line::Wire(timer, wire), "the wiring")?;
        self.say(Line::Latched(timer, latched), "the model of its timer")?;
        let check = order.poll_ms.and_then(|ms| u16::try_from(ms).ok()).unwrap_or(0);
        self.say(Line::Check(timer, check), "the interval of its checks")?;
        let code = self.0.set_speed(timer, order.set_speed, order.call_ms());
        let code = self.heard(code)?;
        if code.is_error() {
            return Err(refused(code).into());
        }
        let watched = self.watch(play, timer, code, wire);
        // The motor is stopped even after a failure.
        let stopped = self.0.stop(timer);
        let course = watched?;
        self.heard(stopped).map(|()| course)
    }

    fn watch<'a>(
        &mut self,
        play: &TimedPlay<'a>,
        timer: u8,
        code: Code,
        wire: Wire,
    ) -> Result<TimedCourse<'a>, Failure> {
        let mut course = TimedCourse::begin(play, code, wire.phase, wire.sequence.len());
        let until = play.until_ms();
        let set_speed = &play.order.set_speed;
        let (mut logged, mut rests) = (0, None);
        loop {
            if interrupt::asked() {
                return Err(Failure::interrupted("interrupted: the motor is stopped"));
            }
            let report = self.0.look(timer);
            let report = self.heard(report)?;
            let due = |n| play.log.and_then(|log: &Moments| log.at(n));
            while due(logged).is_some_and(|ms| ms <= f64::from(report.ms)) {
                course.dumps.push(LoggedDump { ms: report.ms.into(), dump: report.dump });
                logged += 1;
            }
            look(&mut course, report.ms, &report);
            // The callback comes with the next check, or never: the board may have been reset.
            let rested = report.ms.saturating_sub(*rests.get_or_insert(report.ms));
            if report.moving {
                rests = None;
            }
            let check = play.order.poll_ms.filter(|ms| rested <= ms.saturating_add(1_000));
            let waits = check.is_some() && report.reached.is_none();
            let over = !report.moving && !waits && play.for_ms.is_none();
            let last = over && !matches!(play.log, Some(Moments::Each(_)) if due(logged).is_some());
            if last || until.is_some_and(|until| report.ms >= until) {
                course.status = report.dump.status;
                course.moving = report.moving;
                course.end = u64::from(report.ms) * u64::from(self.0.hz()) / 1000;
                let calls = [(report.reached, Call::Reached), (report.fault, Call::Fault)];
                let called = calls.into_iter().filter_map(|(ms, call)| Some((ms?.into(), call)));
                course.calls = called.collect();
                let millis = set_speed.control.has(Control::ENDPOINT_MILLIS);
                let counted = set_speed.limit != 0 && !millis;
                course.made = counted
                    .then(|| u64::from(set_speed.limit.saturating_sub(report.dump.steps_left)));
                return Ok(course);
            }
            let next = due(logged).map_or(LOOK, |ms| (ms.ceil() as u32).saturating_sub(report.ms));
            let left = until.map_or(LOOK, |until| until.saturating_sub(report.ms));
            let time = Duration::from_millis(next.min(left).clamp(1, LOOK).into());
            let paused = self.0.pause(time);
            self.heard(paused)?;
        }
    }
}

/// The failure for a row that was not carried out.
fn failure(name: &str, problem: TimedProblem) -> Failure {
    match problem {
        // The board answered before.
        RowProblem::Lost(trouble) => {
            target::lost(name, &trouble).hint("what it plays goes on; a reset of the board ends it")
        }
        RowProblem::Noise { row } => {
            Failure::new(format!("{name}: noise spoiled the answer to {row}"))
                .hint("the motor is stopped. Look at the cable and its ground")
        }
        RowProblem::Refused { row, reason } => {
            Failure::new(format!("{name} refused {row}: {reason}"))
        }
        RowProblem::Nonsense { row, answer } => {
            Failure::new(format!("{name} answered {answer:?} to {row}"))
                .hint("does it run the same version of the program as this command?")
        }
        RowProblem::OtherProgram(answer) => {
            Failure::new(format!("{name} answered {answer:?} to ?"))
        }
    }
}

/// Records the speed that a board has reported.
fn look(course: &mut TimedCourse, ms: u32, report: &Report) {
    let (top, modification) = (report.dump.top, report.dump.modification);
    if top == 0 || course.updates.last().is_some_and(|last| last.top == top) {
        return;
    }
    if let Ok(fitted) = course.hardware.fit(top) {
        let clock = u64::from(ms) * u64::from(course.hardware.hz()) / 1000;
        let limit = course.order.set_speed.limit;
        let steps = limit.saturating_sub(report.dump.steps_left) as usize;
        course.updates.push(SpeedUpdate { clock, steps, top, modification, fitted });
    }
}

#[cfg(test)]
mod tests;
