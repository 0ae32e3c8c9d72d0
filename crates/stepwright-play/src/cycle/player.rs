//! Plays cycles on the virtual board, and prints their events.

use std::ops::Range;

use stepwright::Ticks;
use stepwright_cycle::{Faults, Homing, HomingError, Status};
use stepwright_path::LivePath;
use stepwright_plot::WayPlot;
use stepwright_sim::{CycleBoard, Edge, Pin, Recorder};

use super::PlayText;
use super::onlooker::{Onlooker, PlayAhead, PlayPart};
use super::told::{Ended, Ending, Told};
use crate::{PlayError, PlayFormat, PlayVoice};
use stepwright_cyclefile::{Act, CyclePlan, JoinedPath, MOST, Move, Stage, Task, TimedAct, along};
use stepwright_plan::sheet::quoted;

/// Records the edges of the motors' pins.
pub trait PlayTape: Recorder {
    /// The edges since the last call, if they were kept.
    fn fetch(&mut self) -> Vec<Edge> {
        Vec::new()
    }
}

impl PlayTape for () {}

/// Plays the cycles of a file on a virtual board.
pub struct CyclePlayer<'p, T: PlayTape> {
    plan: &'p CyclePlan,
    text: &'p PlayText,
    told: Told<'p>,
    board: CycleBoard<'p, T, MOST>,
    format: PlayFormat,
    way: Option<((u8, u8), WayPlot)>,
    limit: u64,
    /// The time at which positions were last printed, and those positions.
    looked: u64,
    shown: Option<Vec<i64>>,
    /// The faults that were reported.
    faults: [Faults; MOST],
    onlooker: Option<&'p mut dyn Onlooker>,
    /// The positions that the onlooker was told last.
    seen: [i64; MOST],
    /// The present path, and the time of its start.
    path: Option<(LivePath, u64)>,
    /// The present path of several pieces.
    joined: Option<JoinedPath>,
    /// Whether the motors were braked, and the rest is dropped.
    braked: bool,
}

impl<'p, T: PlayTape> CyclePlayer<'p, T> {
    /// A player with the file's motors at rest. With a `pair`, draws the path of these two motors.
    /// A cycle that has not ended after `limit` seconds of the board's time is finished.
    pub fn new(
        plan: &'p CyclePlan,
        text: &'p PlayText,
        tape: T,
        format: PlayFormat,
        voice: &'p dyn PlayVoice,
        pair: Option<(u8, u8)>,
        limit: u32,
    ) -> CyclePlayer<'p, T> {
        let mut board = CycleBoard::new(plan.motors, plan.stands, plan.clock, plan.rate, tape);
        board.cycle().set_strategies(plan.strategies);
        for (motor, position) in (0..).zip(plan.positions) {
            // Not refused: no cycle is running yet.
            _ = board.cycle().set_position(motor, position);
        }
        let way = pair.map(|(x, y)| {
            let name = |motor: u8| plan.names[usize::from(motor)].clone();
            let mut way = WayPlot::new((name(x), name(y)), plan.unit.clone());
            let at = |motor: u8| plan.positions[usize::from(motor)];
            way.go(at(x), at(y));
            ((x, y), way)
        });
        let limit = u64::from(limit) * 1_000_000;
        let (looked, shown, faults) = (0, None, [Faults::NONE; MOST]);
        let told = Told::new(plan, text, format, voice);
        let (onlooker, seen, path, joined, braked) = (None, plan.positions, None, None, false);
        CyclePlayer {
            plan,
            text,
            told,
            board,
            format,
            way,
            limit,
            looked,
            shown,
            faults,
            onlooker,
            seen,
            path,
            joined,
            braked,
        }
    }

    /// Adds an onlooker.
    pub fn before(self, onlooker: &'p mut dyn Onlooker) -> CyclePlayer<'p, T> {
        CyclePlayer { onlooker: Some(onlooker), ..self }
    }

    /// Whether the motors were braked before the end.
    pub fn braked(&self) -> bool {
        self.braked
    }

    /// Tells the onlooker that a part begins.
    fn part(&mut self, kind: &'static str, at: &Range<usize>, path: Option<(LivePath, Ticks)>) {
        let begin = self.board.now();
        if let Some(onlooker) = &mut self.onlooker {
            let path = path.as_ref().map(|(path, lead)| (path, *lead));
            onlooker.part(PlayPart { kind, at: at.clone(), begin, path });
        }
        self.path = path.map(|(path, lead)| (path, begin + u64::from(lead)));
        self.joined = None;
    }

    /// Brakes: along the path if there is one, otherwise stops at once.
    fn stop(&mut self) {
        self.braked = true;
        match (&self.path, &self.joined) {
            (Some((path, begin)), _) => {
                let now = self.board.now().saturating_sub(*begin);
                path.finish(self.told.seconds(now));
            }
            (None, Some(path)) => path.look(|route| route.cancel(0.0)),
            (None, None) => self.board.cycle().finish(),
        }
    }

    /// Seconds since the board was switched on.
    pub fn seconds(&self) -> f64 {
        self.told.seconds(self.board.now())
    }

    /// The number of late steps of all cycles.
    pub fn late(&self) -> u32 {
        self.told.late
    }

    /// The time since the board was switched on, in ticks.
    pub fn now(&self) -> u64 {
        self.board.now()
    }

    /// Gives access to the recordings.
    pub fn tape<R>(&mut self, look: impl FnOnce(&mut T) -> R) -> R {
        self.board.with_recorder(look)
    }

    /// The path of two motors.
    pub fn way(&self) -> Option<&WayPlot> {
        self.way.as_ref().map(|(_, way)| way)
    }

    /// The motors' positions, in the file's unit.
    pub fn positions(&mut self) -> Vec<i64> {
        let motors = 0..self.plan.names.len() as u8;
        let cycle = self.board.cycle();
        motors.map(|motor| cycle.position(motor).unwrap_or(0)).collect()
    }

    /// Plays all cycles.
    ///
    /// # Errors
    /// A cycle that is refused, cancelled or endless; an interruption by the voice or the onlooker.
    pub fn play(&mut self, stages: &'p mut [Stage]) -> Result<(), PlayError> {
        if self.format == PlayFormat::Csv {
            self.told.voice.result(&"time_us,motor,event,value,position");
        }
        self.events();
        self.look();
        let mut result = Ok(());
        for (n, stage) in stages.iter_mut().enumerate() {
            result = self.stage(n + 1, stage);
            if let Err(failure) = &result {
                self.told.note(n, failure);
                break;
            }
            if self.braked {
                break;
            }
        }
        let positions = self.positions();
        if self.shown.as_ref() != Some(&positions) {
            self.look();
        }
        result
    }

    fn stage(&mut self, number: usize, stage: &'p mut Stage) -> Result<(), PlayError> {
        let Stage { at, task, moves, acts, rest } = stage;
        let rest = *rest;
        let kind = task.kind();
        if let Task::Home(homing) = task {
            self.part(kind, at, None);
            self.home(number, *homing, at.clone())?;
            return self.rest(at, rest);
        }
        let positions = self.positions();
        moves.extend(along(self.plan, self.text, &positions, task, acts, at)?);
        if moves.is_empty() {
            return self.nothing(number, at, rest);
        }
        let path = moves.first().and_then(Move::path);
        let joined = moves.first().and_then(Move::joined_path);
        let spans: Vec<_> = moves.iter().map(|m| (m.motor, m.at.clone())).collect();
        for part in moves {
            let (motor, calibration) = (part.motor, part.calibration);
            let prepared = self.board.cycle().prepare(motor, part.program(), calibration);
            prepared.map_err(|refusal| self.told.refused(refusal, at.clone()))?;
        }
        if let Err(refusal) = self.board.cycle().start() {
            let span = spans.iter().find(|(motor, _)| Some(*motor) == refusal.motor());
            let span = span.map_or_else(|| at.clone(), |(_, span)| span.clone());
            return Err(self.told.refused(refusal, span));
        }
        let begun = self.board.now();
        self.part(kind, at, path);
        self.joined = joined;
        self.row("start");
        self.events();
        for TimedAct { us, act, .. } in acts.iter() {
            self.go_to_rest(begun + self.told.ticks(*us))?;
            if !self.board.cycle().is_running() {
                break;
            }
            // An act is never refused while a cycle runs.
            let name = match act {
                Act::Pause => {
                    _ = self.board.cycle().pause();
                    "pause"
                }
                Act::Resume => {
                    _ = self.board.cycle().resume();
                    "resume"
                }
                Act::Finish => {
                    self.board.cycle().finish();
                    "finish"
                }
                // Acts of a path, whose law contains them.
                Act::Feed(_) | Act::To(_) => continue,
            };
            self.row(name);
            self.events();
        }
        let limit = begun + self.told.ticks(self.limit);
        self.go_to_rest(limit)?;
        let over = self.is_cut_off();
        self.report(number, begun);
        if over {
            return Err(self.told.endless(number, self.limit / 1_000_000, at.clone()));
        }
        match self.board.cycle().error() {
            Some(error) => {
                let seconds = self.told.seconds(self.board.now() - begun);
                let faults = |motor| self.board.cycle().faults(motor);
                Err(self.told.cancelled(number, seconds, error, faults, &spans, at.clone()))
            }
            None => self.rest(at, rest),
        }
    }

    /// Handles a line without length: the motors are at its end already.
    fn nothing(&mut self, number: usize, at: &Range<usize>, rest: u64) -> Result<(), PlayError> {
        self.row("start");
        self.row("end");
        self.told.nothing(number);
        self.rest(at, rest)
    }

    /// Rests for this many µs.
    fn rest(&mut self, at: &Range<usize>, rest: u64) -> Result<(), PlayError> {
        if rest > 0 && !self.braked {
            self.part("rest", at, None);
            self.go(self.board.now() + self.told.ticks(rest))?;
        }
        Ok(())
    }

    /// Homes a motor.
    fn home(
        &mut self,
        number: usize,
        mut homing: Homing,
        at: Range<usize>,
    ) -> Result<(), PlayError> {
        let begun = self.board.now();
        let limit = begun + self.told.ticks(self.limit);
        self.row("start");
        loop {
            let done = homing.poll(self.board.cycle()).map_err(|error| match error {
                HomingError::Refused(refusal) => self.told.refused(refusal, at.clone()),
                error => self.text.blame(at.clone(), format_args!("cycle {number}: {error}")),
            })?;
            if done {
                break;
            }
            self.go_to_rest(limit)?;
            if self.braked {
                self.board.cycle().finish();
                return Ok(());
            }
            if self.is_cut_off() {
                self.report(number, begun);
                let endless = self.told.endless(number, self.limit / 1_000_000, at);
                return Err(endless.hint("give a longer --limit"));
            }
        }
        self.row("end");
        let seconds = self.told.seconds(self.board.now() - begun);
        self.told.home(number, homing.motor, seconds);
        Ok(())
    }

    /// Finishes a cycle that has not ended within the limit. Returns whether there was one.
    fn is_cut_off(&mut self) -> bool {
        let over = self.board.cycle().is_running();
        if over {
            self.board.cycle().finish();
            self.row("finish");
        }
        over
    }

    /// Reports the end of a cycle, for csv, json and standard error.
    fn report(&mut self, number: usize, begun: u64) {
        let error = self.board.cycle().error();
        let mut stopped = Vec::new();
        for motor in 0..self.plan.names.len() as u8 {
            let faults = self.board.cycle().faults(motor);
            if !faults.is_none() && self.board.cycle().status(motor) == Status::Finished {
                stopped.push((motor, faults));
            }
        }
        self.row(if error.is_some() { "cancelled" } else { "end" });
        let (late, longest) = (self.board.cycle().late(), self.board.cycle().longest());
        let seconds = self.told.seconds(self.board.now() - begun);
        self.told.ended(number, &Ending { seconds, error, late, longest, stopped });
    }

    /// Lets time pass until `time`.
    fn go(&mut self, time: u64) -> Result<(), PlayError> {
        self.pass(time, false)
    }

    /// Lets time pass until the cycle is over, or until `limit`.
    fn go_to_rest(&mut self, limit: u64) -> Result<(), PlayError> {
        self.pass(limit, true)
    }

    fn pass(&mut self, time: u64, to_rest: bool) -> Result<(), PlayError> {
        let second = u64::from(self.plan.rate.hz());
        let mut due = self.looked + second;
        while self.board.now() < time {
            if to_rest && !self.board.cycle().is_running() {
                break;
            }
            if self.told.voice.asked() {
                return Err(PlayError::interrupted("interrupted"));
            }
            due = due.max(self.looked + second);
            let may = self.may()?;
            if self.braked && !self.board.cycle().is_running() {
                break;
            }
            let limit = due.min(time).min(may);
            // A limited number of events at a time, so that Ctrl-C is noticed.
            let mut events = 0;
            let mut more = true;
            while more && events < 10_000 {
                more = self.board.pass(limit);
                events += 1;
                self.events();
                if to_rest && !self.board.cycle().is_running() {
                    break;
                }
            }
            if more {
                continue;
            }
            self.board.run_until(limit);
            if limit == due {
                let cycle = self.board.cycle();
                let moving = cycle.is_running() && !cycle.is_paused();
                if moving || due - self.looked >= 10 * second {
                    self.look();
                }
                due += second;
            }
        }
        Ok(())
    }

    /// The tick up to which to play.
    fn may(&mut self) -> Result<u64, PlayError> {
        let now = self.board.now();
        let said = self.onlooker.as_mut().map(|onlooker| onlooker.may(now)).transpose()?;
        match said {
            None => Ok(u64::MAX),
            Some(PlayAhead::On(to)) => Ok(to),
            Some(PlayAhead::Stop) => {
                if !self.braked {
                    self.stop();
                }
                Ok(now)
            }
        }
    }

    /// Prints the positions.
    fn look(&mut self) {
        let positions = self.positions();
        self.looked = self.board.now();
        self.told.list(&positions);
        self.shown = Some(positions);
    }

    /// Reports the edges of the pins since the last call.
    fn events(&mut self) {
        if let Some(onlooker) = &mut self.onlooker {
            let cycle = self.board.cycle();
            let known = (0u8..).zip(&mut self.seen).take(self.plan.names.len());
            let moved = known.fold(false, |moved, (motor, seen)| {
                let now = cycle.position(motor).unwrap_or(0);
                std::mem::replace(seen, now) != now || moved
            });
            if moved {
                onlooker.at(self.board.now(), &self.seen);
            }
        }
        if self.format != PlayFormat::Csv && self.way.is_none() {
            return;
        }
        let edges = self.board.with_recorder(T::fetch);
        if let Some(((x, y), way)) = &mut self.way {
            let cycle = self.board.cycle();
            way.go(cycle.position(*x).unwrap_or(0), cycle.position(*y).unwrap_or(0));
        }
        if self.format == PlayFormat::Csv {
            edges.iter().for_each(|edge| self.edge(edge));
            for (motor, name) in (0u8..).zip(&self.plan.names) {
                let faults = self.board.cycle().faults(motor);
                let told = &mut self.faults[usize::from(motor)];
                if std::mem::replace(told, faults) != faults && !faults.is_none() {
                    let (time, faults) = (self.told.micros(self.board.now()), faults.to_string());
                    let position = self.board.cycle().position(motor).unwrap_or(0);
                    let faults = faults.replace(", ", " ");
                    let name = quoted(name);
                    self.told
                        .voice
                        .result(&format_args!("{time},{name},fault,{faults},{position}"));
                }
            }
        }
    }

    fn edge(&mut self, edge: &Edge) {
        let Some(name) = self.plan.names.get(usize::from(edge.axis)) else { return };
        let (event, value) = match edge.pin {
            Pin::Step => ("step", edge.level),
            Pin::Direction => ("dir", edge.level),
            // The motors of cycles have no coils.
            Pin::Coil(_) => return,
            // A low level turns a driver on.
            Pin::Enable => ("enable", !edge.level),
            Pin::Min => ("switch-min", edge.level),
            Pin::Max => ("switch-max", edge.level),
        };
        let position = self.board.cycle().position(edge.axis).unwrap_or(0);
        let (time, name) = (self.told.micros(edge.time), quoted(name));
        self.told
            .voice
            .result(&format_args!("{time},{name},{event},{},{position}", u8::from(value)));
    }

    /// Prints a row of csv about the cycle.
    fn row(&mut self, value: &str) {
        if self.format == PlayFormat::Csv {
            self.events();
            let time = self.told.micros(self.board.now());
            self.told.voice.result(&format_args!("{time},,cycle,{value},"));
        }
    }

    /// The result of all cycles as JSON.
    pub fn json(&mut self) -> String {
        let positions = self.positions();
        let motors = (0u8..).zip(&positions);
        let motors: Vec<_> = motors
            .map(|(motor, position)| {
                let cycle = self.board.cycle();
                let (status, faults) = (cycle.status(motor), cycle.faults(motor));
                Ended { position: *position, status, faults, known: cycle.motor(motor) }
            })
            .collect();
        self.told.json(self.seconds(), &motors)
    }
}
