//! Plays the cycles of a file on a real board, and prints their events.
//!
//! The board reports the positions of its motors, and the times at which a cycle began, was paused
//! and ended, but not the times of its steps. So csv has a row `at` for each poll instead of a row
//! for each edge.

use std::ops::Range;
use std::time::Duration;

use stepwright_cycle::line::{CycleFault, CycleLine, CycleReport, LineAct, MotorPins, MotorReport};
use stepwright_cycle::{AtTiming, Clock, Faults, Leg, Motor, Refusal, Status};

use super::PlayText;
use super::port;
use super::told::{Ended, Ending, Told};
use crate::{PlayError, PlayFormat, PlayVoice};
use stepwright_cyclefile::{Act, CyclePlan, Pins, Stage, Task, TimedAct, along};
use stepwright_host::programs::{CycleProblem, CycleSession, RowProblem};
use stepwright_plan::sheet::quoted;
use stepwright_protocol::Fault;

/// The code of a report for a homing that has found its switch.
const HOME: u8 = 2;

/// The longest time between two polls of the motors.
const LOOK: Duration = Duration::from_millis(100);

/// Plays the cycles of a file on a board.
pub struct CyclesOnBoard<'p> {
    board: CycleSession,
    plan: &'p CyclePlan,
    text: &'p PlayText,
    told: Told<'p>,
    /// The number of the last cycle.
    number: u8,
    /// Ticks of all cycles and rests before the present one, as if each followed the other without
    /// a pause.
    before: u64,
    /// The time in seconds of the next line of positions.
    due: u64,
    limit: u64,
    shown: Option<Vec<i64>>,
    /// The faults that were reported, and their times.
    faults: Vec<(u8, Option<u64>)>,
    last: Option<CycleReport>,
    watcher: Option<CycleWatcher<'p>>,
}

/// Called at each poll of the motors with the ticks since the start and the positions.
type CycleWatcher<'p> = &'p mut dyn FnMut(u64, &[i64]);

impl<'p> CyclesOnBoard<'p> {
    /// A player on a connected board. A cycle that has not ended after `limit` seconds is finished.
    pub fn new(
        board: CycleSession,
        plan: &'p CyclePlan,
        text: &'p PlayText,
        format: PlayFormat,
        voice: &'p dyn PlayVoice,
        limit: u32,
    ) -> CyclesOnBoard<'p> {
        let told = Told::new(plan, text, format, voice);
        let faults = vec![(0, None); plan.names.len()];
        let (limit, last) = (limit.into(), None);
        let (number, before, due, shown) = (0, 0, 0, None);
        let watcher = None;
        CyclesOnBoard {
            board,
            plan,
            text,
            told,
            number,
            before,
            due,
            limit,
            shown,
            faults,
            last,
            watcher,
        }
    }

    /// Calls `watcher` at each poll of the motors, with the ticks since the start, including rests
    /// between cycles, and the positions.
    pub fn watch_by(&mut self, watcher: CycleWatcher<'p>) {
        self.watcher = Some(watcher);
    }

    /// The duration of all cycles and rests so far, in seconds.
    pub fn seconds(&self) -> f64 {
        self.told.seconds(self.before)
    }

    /// The number of late steps of all cycles.
    pub fn late(&self) -> u32 {
        self.told.late
    }

    /// Plays all cycles. Also after an error, no motor is left moving.
    ///
    /// # Errors
    /// A file for which the board has no room; a cycle that is refused, cancelled or endless; a
    /// lost line; an interruption by the voice.
    pub fn play(&mut self, stages: &mut [Stage]) -> Result<(), PlayError> {
        self.check(stages)?;
        let report = self.look()?;
        if report.running {
            return Err(PlayError::new(format!("{} plays a cycle", self.board.name()))
                .hint("let it end, or end it by a reset of the board"));
        }
        self.number = report.number;
        self.set_up()?;
        if self.told.format == PlayFormat::Csv {
            self.told.voice.result(&"time_us,motor,event,value,position");
        }
        let report = self.look()?;
        for (motor, name) in self.motors(&report).iter().zip(&self.plan.names) {
            if motor.uncertain {
                self.told.voice.note(&format_args!(
                    "the position of {name} is unknown since a kill or a reset, and counted from \
                     {}: give the motor a position, or home it",
                    motor.position
                ));
            }
        }
        self.print(&report);
        let mut result = Ok(());
        for (n, stage) in stages.iter_mut().enumerate() {
            result = self.stage(n + 1, stage);
            if let Err(failure) = &result {
                // Errors are ignored, since the line itself may have failed.
                _ = self.board.say(&CycleLine::Now(LineAct::Finish));
                self.told.note(n, failure);
                break;
            }
        }
        if let Ok(report) = self.board.look()
            && self.shown.as_ref() != Some(&self.positions(&report))
        {
            self.print(&report);
        }
        result
    }

    /// Checks that the board can play all cycles, before anything moves.
    fn check(&self, stages: &mut [Stage]) -> Result<(), PlayError> {
        let (board, called) = (&self.board, self.board.name());
        let (has, name) = (self.plan.names.len(), board.board());
        if has > board.motors() {
            return Err(self
                .text
                .blame(
                    self.plan.at[board.motors()].clone(),
                    format_args!(
                        "this {name} moves {} motors, and the file has {has}",
                        board.motors()
                    ),
                )
                .hint("leave motors out, or play it on a Mega, which moves four"));
        }
        if self.plan.rate.hz() != board.hz() {
            return Err(PlayError::new(format!("the timer of {called} runs at {} Hz", board.hz()))
                .hint("leave timer-hz out of the file"));
        }
        if self.plan.strategies.hard_end.brakes() && !board.can("brakes") {
            return Err(PlayError::new(format!("a {name} has no room for braking at a switch"))
                .hint("let hard-end be \"stop-motor\" or \"cancel\", or play it on a Mega"));
        }
        if self.plan.clock != Clock::Deadlines && !board.can("tick") {
            return Err(PlayError::new(format!("a {name} has no room for the fixed tick")).hint(
                "leave tick-us out of the file: every step has its own deadline then; \
                 or play it on a Mega",
            ));
        }
        for (n, stage) in stages.iter_mut().enumerate() {
            match stage.task {
                Task::Line(..) | Task::Arc(..) | Task::Path(_) if !board.can("paths") => {
                    let what = format_args!("a {name} has no room for lines and arcs");
                    return Err(self
                        .text
                        .blame(stage.at.clone(), what)
                        .hint("play it on a Mega; `stepwright line --port` moves the controller of either along a line"));
                }
                Task::Home(_) if !board.can("home") => {
                    let what = format_args!("a {name} has no room for homing");
                    return Err(self
                        .text
                        .blame(stage.at.clone(), what)
                        .hint("home by a whirl with calibrate = \"start-min\", or on a Mega"));
                }
                _ => {}
            }
            let mut legs = Vec::new();
            for part in &mut stage.moves {
                let said = part.line(&mut legs);
                if legs.len() > board.legs() {
                    let what = format_args!(
                        "cycle {} has {} delays and legs of series so far, {} more than a {name} \
                         keeps ({})",
                        n + 1,
                        legs.len(),
                        legs.len() - board.legs(),
                        board.legs()
                    );
                    return Err(self.text.blame(part.at.clone(), what).hint(
                        "make two cycles of it, a ramp-us of the list, or play it on a Mega, \
                         which keeps 400",
                    ));
                }
                if said.is_none() {
                    let what = "each is at most 2147483647 on a board";
                    return Err(self.text.blame(part.at.clone(), what));
                }
            }
        }
        Ok(())
    }

    /// Sends a line that must not be refused.
    fn say(&mut self, line: CycleLine) -> Result<(), PlayError> {
        let said = self.board.say(&line);
        self.heard(said)
    }

    /// Requests a report of the board.
    fn look(&mut self) -> Result<CycleReport, PlayError> {
        let report = self.board.look();
        self.heard(report)
    }

    /// Lets time pass.
    fn pause(&mut self, time: Duration) -> Result<(), PlayError> {
        let paused = self.board.pause(time);
        self.heard(paused)
    }

    /// Converts the problem of a row to an error.
    fn heard<T>(&self, result: Result<T, CycleProblem>) -> Result<T, PlayError> {
        result.map_err(|problem| port::failure(&self.board.name(), problem))
    }

    /// Tells the board the motors and their pins.
    fn set_up(&mut self) -> Result<(), PlayError> {
        self.say(CycleLine::New)?;
        // Pins may be used differently by the file before: frees all pins first.
        for motor in 0..self.board.motors() as u8 {
            self.say(CycleLine::Wire(motor, MotorPins::NONE))?;
        }
        self.say(CycleLine::Clock(self.plan.clock, self.plan.strategies))?;
        for (n, pins) in self.plan.pins.iter().enumerate() {
            let (motor, at) = (n as u8, self.plan.at[n].clone());
            let codes = pins.codes(self.text, n, at.clone(), port::arduino(&self.board))?;
            self.say(CycleLine::Motor(motor, bounded(self.plan.motors[n])))?;
            match self.board.say(&CycleLine::Wire(motor, codes)) {
                Err(RowProblem::Refused {
                    reason: Fault::Own(CycleFault::Pin { number }), ..
                }) => {
                    let which = Pins::name(usize::from(number).saturating_sub(2));
                    let what = format_args!(
                        "its pin {which} is one of the serial line's, or has another part already"
                    );
                    return Err(self.text.blame(at, what));
                }
                said => self.heard(said)?,
            }
            if self.plan.placed[n] {
                let at = self.plan.positions[n].max(i64::MIN + 1);
                self.say(CycleLine::Position(motor, at))?;
            }
        }
        Ok(())
    }

    fn stage(&mut self, number: usize, stage: &mut Stage) -> Result<(), PlayError> {
        self.say(CycleLine::New)?;
        let mut spans = Vec::new();
        let mut legs: Vec<Leg> = Vec::new();
        let mut lines = Vec::new();
        let path = matches!(stage.task, Task::Line(..) | Task::Arc(..) | Task::Path(_));
        if path && !self.plan_path(number, stage)? {
            return self.stand(stage.rest);
        }
        for part in &mut stage.moves {
            spans.push((part.motor, part.at.clone()));
            let program = part.line(&mut legs);
            if legs.len() > self.board.legs() {
                let what = format_args!(
                    "the path of cycle {number} is {} runs, and a {} keeps {}",
                    legs.len(),
                    self.board.board(),
                    self.board.legs()
                );
                return Err(self
                    .text
                    .blame(stage.at.clone(), what)
                    .hint("make two cycles of it: each begins and ends at rest"));
            }
            let Some(program) = program else {
                let what = "a path that stays paused has no end, and a board plays it to its end";
                return Err(self
                    .text
                    .blame(part.at.clone(), what)
                    .hint("give resume-s or finish-s"));
            };
            lines.push(CycleLine::Prepare(part.motor, part.calibration, program));
        }
        for (place, leg) in (0u16..).zip(&legs) {
            self.say(CycleLine::Leg(place, *leg))?;
        }
        for line in lines {
            self.say(line)?;
        }
        for TimedAct { us, act, .. } in &stage.acts {
            let act = match act {
                Act::Pause => LineAct::Pause,
                Act::Resume => LineAct::Resume,
                Act::Finish => LineAct::Finish,
                Act::Feed(_) | Act::To(_) => continue,
            };
            self.say(CycleLine::Act(act, self.told.ticks(*us)))?;
        }
        self.number = self.number.checked_add(1).unwrap_or(1);
        let home = match stage.task {
            Task::Home(homing) => Some(homing),
            _ => None,
        };
        let go = match home {
            Some(homing) => CycleLine::Home(self.number, homing),
            None => CycleLine::Start(self.number),
        };
        match self.board.say(&go) {
            Err(RowProblem::Refused {
                reason: Fault::Own(CycleFault::Refused(refusal)), ..
            }) => return Err(self.refused(refusal, &spans, &stage.at)),
            said => self.heard(said)?,
        }
        let report = self.watch(number, stage)?;
        let seconds = self.told.seconds(report.time);
        let at = stage.at.clone();
        if let Some(homing) = home {
            let failed = |what| self.text.blame(at.clone(), format_args!("cycle {number}: {what}"));
            match report.home {
                HOME => self.told.home(number, homing.motor, seconds),
                3 => {
                    return Err(failed(
                        "the switch was not found: is it connected, and the reach long enough?",
                    ));
                }
                4 => {
                    return Err(failed(
                        "the switch is still closed after backing off: back off further",
                    ));
                }
                _ => match report.home_refusal(homing.motor) {
                    Some(refusal) => return Err(self.told.refused(refusal, at)),
                    None => return Err(failed("stopped on the way")),
                },
            }
        } else {
            let (late, longest, error) = (report.late, report.longest, report.error);
            let motors = self.motors(&report);
            let stopped = (0u8..).zip(motors).filter(|(_, m)| m.status == 2 && m.faults != 0);
            let stopped = stopped.map(|(motor, m)| (motor, Faults::from_bits(m.faults))).collect();
            self.told.ended(number, &Ending { seconds, error, late, longest, stopped });
            if let Some(error) = error {
                let faults = |motor: u8| {
                    let motor = report.motors.get(usize::from(motor));
                    Faults::from_bits(motor.map_or(0, |motor| motor.faults))
                };
                return Err(self.told.cancelled(number, seconds, error, faults, &spans, at));
            }
        }
        self.before += report.time;
        self.stand(stage.rest)
    }

    /// Plans a path from the motors' positions. Returns false if they are at its end already.
    fn plan_path(&mut self, number: usize, stage: &mut Stage) -> Result<bool, PlayError> {
        let report = self.look()?;
        let positions = self.positions(&report);
        let Stage { task, moves, acts, at, .. } = stage;
        *moves = along(self.plan, self.text, &positions, task, acts, at)?;
        if moves.is_empty() {
            if self.told.format == PlayFormat::Csv {
                let time = self.told.micros(self.before);
                self.told.voice.result(&format_args!("{time},,cycle,start,"));
                self.told.voice.result(&format_args!("{time},,cycle,end,"));
            }
            self.told.nothing(number);
        }
        Ok(!moves.is_empty())
    }

    /// The error for a cycle that did not start, at the line of the motor that caused it.
    fn refused(
        &self,
        refusal: Refusal,
        spans: &[(u8, Range<usize>)],
        at: &Range<usize>,
    ) -> PlayError {
        let span = spans.iter().find(|(motor, _)| Some(*motor) == refusal.motor());
        let at = span.map_or_else(|| at.clone(), |(_, span)| span.clone());
        let failure = self.told.refused(refusal, at);
        let ignores = self.plan.strategies.timing == AtTiming::Ignore;
        match refusal {
            Refusal::TooFast { .. } if !ignores && self.board.can("paths") => failure.hint(
                "make it slower; along a line or an arc timing = \"ignore\" under [strategies] \
                 lets a step come late, and allows 200 µs",
            ),
            _ => failure,
        }
    }

    /// Watches the cycle until it is over. Returns the last report.
    fn watch(&mut self, number: usize, stage: &Stage) -> Result<CycleReport, PlayError> {
        if self.told.format == PlayFormat::Csv {
            let time = self.told.micros(self.before);
            self.told.voice.result(&format_args!("{time},,cycle,start,"));
        }
        let limit = self.told.ticks(self.limit * 1_000_000);
        let mut acts = [None; 3];
        loop {
            if self.told.voice.asked() {
                self.say(CycleLine::Now(LineAct::Finish))?;
                return Err(PlayError::interrupted("interrupted: the motors stand"));
            }
            let mut report = self.look()?;
            if faults(self.motors(&report)) != self.faults {
                // The positions were read before the faults; the next report has those of the end.
                report = self.look()?;
            }
            self.tell(&report, &mut acts);
            if !report.running {
                return Ok(report);
            }
            if report.time > limit {
                self.say(CycleLine::Now(LineAct::Finish))?;
                return Err(self.told.endless(number, self.limit, stage.at.clone()));
            }
            let now = self.told.seconds(self.before + report.time);
            if now >= self.due as f64 {
                self.due = now as u64 + 1;
                if !report.paused {
                    self.print(&report);
                }
            }
            let left = Duration::from_secs_f64((self.due as f64 - now).max(0.001));
            self.pause(left.min(LOOK))?;
        }
    }

    /// Prints the new events of a report, in the order of their times.
    fn tell(&mut self, report: &CycleReport, acts: &mut [Option<u64>; 3]) {
        let positions = self.positions(report);
        if let Some(watcher) = &mut self.watcher {
            watcher(self.before + report.time, &positions);
        }
        if self.told.format != PlayFormat::Csv {
            self.faults = faults(self.motors(report));
            return;
        }
        let mut rows: Vec<(u64, String, &str, String, String)> = Vec::new();
        for (which, word) in ["pause", "resume", "finish"].into_iter().enumerate() {
            if let (Some(at), None) = (report.acts[which], acts[which]) {
                rows.push((at, String::new(), "cycle", word.into(), String::new()));
            }
        }
        *acts = report.acts;
        for (n, motor) in self.motors(report).iter().enumerate() {
            let now = (motor.faults, motor.fault_at);
            let told = std::mem::replace(&mut self.faults[n], now);
            if motor.faults != 0 && now != told {
                let faults = Faults::from_bits(motor.faults).to_string().replace(", ", " ");
                let (name, at) = (quoted(&self.plan.names[n]), motor.position.to_string());
                let time = motor.fault_at.unwrap_or(report.time);
                rows.push((time, name.to_string(), "fault", faults, at));
            }
        }
        for (n, motor) in self.motors(report).iter().enumerate() {
            let (name, at) = (quoted(&self.plan.names[n]), motor.position.to_string());
            rows.push((report.time, name.to_string(), "at", String::new(), at));
        }
        if !report.running {
            // The switch that a homing finds cancels its last cycle.
            let cancelled = report.error.is_some() && report.home != HOME;
            let word = if cancelled { "cancelled" } else { "end" };
            rows.push((report.time, String::new(), "cycle", word.into(), String::new()));
        }
        rows.sort_by_key(|row| row.0);
        for (time, motor, event, value, position) in rows {
            let time = self.told.micros(self.before + time);
            self.told.voice.result(&format_args!("{time},{motor},{event},{value},{position}"));
        }
    }

    /// Rests for this many µs.
    fn stand(&mut self, us: u64) -> Result<(), PlayError> {
        let (mut left, mut shown) = (Duration::from_micros(us), Duration::ZERO);
        while !left.is_zero() {
            if self.told.voice.asked() {
                return Err(PlayError::interrupted("interrupted: the motors stand"));
            }
            let piece = left.min(LOOK);
            self.pause(piece)?;
            left -= piece;
            shown += piece;
            if shown >= Duration::from_secs(10) {
                shown = Duration::ZERO;
                let report = self.look()?;
                self.print(&report);
            }
        }
        self.before += self.told.ticks(us);
        Ok(())
    }

    /// The motors of the file.
    fn motors<'r>(&self, report: &'r CycleReport) -> &'r [MotorReport] {
        report.motors.get(..self.plan.names.len()).unwrap_or(&report.motors)
    }

    fn positions(&self, report: &CycleReport) -> Vec<i64> {
        self.motors(report).iter().map(|motor| motor.position).collect()
    }

    /// Prints the positions.
    fn print(&mut self, report: &CycleReport) {
        let positions = self.positions(report);
        self.told.list(&positions);
        self.shown = Some(positions);
        self.last = Some(*report);
    }

    /// The result of all cycles as JSON.
    pub fn json(&self) -> String {
        let Some(report) = &self.last else { return self.told.json(0.0, &[]) };
        let motors: Vec<_> = (self.motors(report).iter().zip(&self.plan.motors))
            .map(|(motor, known)| Ended {
                position: motor.position,
                status: match motor.status {
                    0 => Status::Idle,
                    1 => Status::Running,
                    _ => Status::Finished,
                },
                faults: Faults::from_bits(motor.faults),
                known: Some(Motor { max: motor.max, ..*known }),
            })
            .collect();
        self.told.json(self.told.seconds(self.before), &motors)
    }
}

/// The faults of motors, and their times.
fn faults(motors: &[MotorReport]) -> Vec<(u8, Option<u64>)> {
    motors.iter().map(|motor| (motor.faults, motor.fault_at)).collect()
}

/// Limits the bounds of a motor to numbers that fit a line.
fn bounded(motor: Motor) -> Motor {
    let fit = |at: i64| at.max(i64::MIN + 1);
    Motor { min: motor.min.map(fit), max: motor.max.map(fit), ..motor }
}

#[cfg(test)]
mod tests;
