//! The checked contents of a cycle file. Only the start of a cycle can still fail.

use std::ops::Range;

use stepwright::{OutOfRange, Rate, Ticks};
use stepwright_cycle::line::LineProgram;
use stepwright_cycle::{
    Calibration, Clock, DelayRamp, End, Homing, Leg, Motor, Program, Strategies,
};
use stepwright_path::{LivePath, Pace, SCALES, Steps, Unplannable};
use stepwright_sim::Stand;
use toml::Spanned;

use crate::file::{self, File, Way};
use crate::joined::{Joined, JoinedPath, JoinedSteps};
use crate::pins::Pins;
use crate::text::{CycleText, FileError, plain};

/// The most motors of a cycle.
pub const MOST: usize = 8;

/// The motors and the cycles of a file.
pub struct CyclePlan {
    /// The unit of positions.
    pub unit: String,
    /// The rate of the step timer.
    pub rate: Rate,
    /// A fixed tick, or deadlines.
    pub clock: Clock,
    /// The strategies at ends and for small delays.
    pub strategies: Strategies,
    /// The names of the motors, in the order of the file.
    pub names: Vec<String>,
    /// The motors.
    pub motors: [Motor; MOST],
    /// The positions of their virtual switches, in steps.
    pub stands: [Stand; MOST],
    /// Their positions at the beginning.
    pub positions: [i64; MOST],
    /// Whether the file gives the position of each motor.
    pub placed: [bool; MOST],
    /// The pins of a board.
    pub pins: Vec<Pins>,
    /// The place of each motor in the file.
    pub at: Vec<Range<usize>>,
    /// The cycles, one after the other.
    pub stages: Vec<Stage>,
}

/// A cycle, and its place in the file.
pub struct Stage {
    /// Its place in the file.
    pub at: Range<usize>,
    /// The kind of the cycle.
    pub task: Task,
    /// The moves of the motors.
    pub moves: Vec<Move>,
    /// The changes while it runs, in the order of their times.
    pub acts: Vec<TimedAct>,
    /// The rest after the cycle, in µs.
    pub rest: u64,
}

/// The kind of a cycle, beside moves that are known before it starts.
pub enum Task {
    /// Only such moves.
    Moves,
    /// A line: motors, and the positions to which they move.
    Line(Vec<(u8, i64)>, Pace),
    /// An arc: two motors around a centre, by an angle in radians.
    Arc([u8; 2], [i64; 2], f64, Pace),
    /// Several lines and arcs, without a stop.
    Path(Joined),
    /// Homing to a switch.
    Home(Homing),
}

impl Task {
    /// Its name for drawings.
    pub fn kind(&self) -> &'static str {
        match self {
            Task::Moves => "moves",
            Task::Line(..) => "line",
            Task::Arc(..) => "arc",
            Task::Path(_) => "path",
            Task::Home(_) => "home",
        }
    }
}

/// A change of a cycle while it runs, and its place in the file.
pub struct TimedAct {
    /// The time after the start of the cycle, in µs.
    pub us: u64,
    /// Its place in the file.
    pub at: Range<usize>,
    /// The change.
    pub act: Act,
}

/// A change of a cycle while it runs.
pub enum Act {
    /// The motors stop, and the cycle waits.
    Pause,
    /// The motors continue.
    Resume,
    /// The cycle ends early.
    Finish,
    /// A new speed along a path, as a factor of the ordered speed.
    Feed(f64),
    /// A new end of a path.
    To(Vec<(u8, i64)>),
}

/// The move of one motor.
pub struct Move {
    /// The motor, counted from 0.
    pub motor: u8,
    /// Its place in the file.
    pub at: Range<usize>,
    /// Its effect on positions and bounds.
    pub calibration: Calibration,
    does: Does,
}

enum Does {
    Steps(i32, u32),
    Whirl(bool, u32),
    List(Vec<u32>, u32, bool),
    Series(Vec<Leg>),
    Ramp(Option<u32>, bool, DelayRamp),
    /// The steps of a path, and the smallest delay of their motor, in ticks.
    Paced(Steps, Ticks),
    /// The same for a path of several pieces, with that path.
    Joined(JoinedSteps, JoinedPath, Ticks),
}

impl Move {
    /// Steps along a path.
    pub fn paced(motor: u8, at: Range<usize>, steps: Steps, least: Ticks) -> Move {
        Move { motor, at, calibration: Calibration::None, does: Does::Paced(steps, least) }
    }

    /// Steps along a path of several pieces.
    pub(crate) fn joined(
        motor: u8,
        at: Range<usize>,
        steps: JoinedSteps,
        path: JoinedPath,
        least: Ticks,
    ) -> Move {
        let does = Does::Joined(steps, path, least);
        Move { motor, at, calibration: Calibration::None, does }
    }

    /// The path of several pieces that it is a part of.
    pub fn joined_path(&self) -> Option<JoinedPath> {
        match &self.does {
            Does::Joined(_, path, _) => Some(path.clone()),
            _ => None,
        }
    }

    /// The path that it is a part of, and the ticks from the start to the beginning of the path.
    pub fn path(&self) -> Option<(LivePath, Ticks)> {
        match &self.does {
            Does::Paced(steps, _) => Some((steps.law(), steps.lead())),
            _ => None,
        }
    }

    /// The program for the cycle.
    pub fn program(&mut self) -> Program<'_> {
        match &mut self.does {
            &mut Does::Steps(count, delay) => Program::Steps { count, delay },
            &mut Does::Whirl(forward, delay) => Program::Whirl { forward, delay },
            Does::List(delays, each, forward) => {
                Program::List { delays, each: *each, forward: *forward }
            }
            Does::Series(legs) => Program::Series(legs),
            Does::Paced(steps, _) => Program::Paced(steps),
            Does::Joined(steps, ..) => Program::Paced(steps),
            &mut Does::Ramp(steps, forward, ramp) => Program::Ramp { steps, forward, ramp },
        }
    }

    /// The program for the serial line to a board. Its legs are added to the end of `legs`. `None` if the line
    /// has no such program.
    pub fn line(&mut self, legs: &mut Vec<Leg>) -> Option<LineProgram> {
        let first = u16::try_from(legs.len()).ok()?;
        match &mut self.does {
            &mut Does::Steps(count, delay) => return Some(LineProgram::Steps { count, delay }),
            &mut Does::Whirl(forward, delay) => return Some(LineProgram::Whirl { forward, delay }),
            &mut Does::Ramp(steps, forward, ramp) => {
                return Some(LineProgram::Ramp { steps, forward, ramp });
            }
            Does::Series(series) => legs.extend(series.iter()),
            Does::List(delays, each, forward) => {
                let count = i32::try_from(*each).ok()?;
                let count = if *forward { count } else { -count };
                legs.extend(delays.iter().map(|&delay| Leg::Steps { count, delay }));
            }
            Does::Joined(steps, _, least) => {
                let error = steps.rate().micros(RUN_ERROR);
                legs.extend(stepwright_path::legs(steps, error, *least));
            }
            Does::Paced(steps, least) => {
                // A path that is paused for ever has no last step.
                steps.law().end()?;
                let error = steps.rate().micros(RUN_ERROR);
                legs.extend(stepwright_path::legs(steps, error, *least));
            }
        }
        let count = u16::try_from(legs.len() - usize::from(first)).ok()?;
        Some(LineProgram::Legs { first, count })
    }
}

/// The largest error of a step of a path on a board, in µs: 1 % of an interval of 0.2 ms.
const RUN_ERROR: u32 = 2;

/// The error of a cycle of several kinds.
const ONE: &str = "a cycle has either moves, or a line, or an arc, or a path, or a home";

/// Reads and checks a file.
/// # Errors
/// The first mistake.
pub fn read(text: &CycleText) -> Result<CyclePlan, FileError> {
    let file: File = toml::from_str(&text.text)
        .map_err(|error| text.blame(error.span().unwrap_or(0..0), plain(error.message())))?;
    let range = |span, error: OutOfRange| text.blame(span, error);
    let mut rate = Rate::from_hz(16_000_000).map_err(|error| range(0..0, error))?;
    if let Some(hz) = &file.clock.timer_hz {
        rate = Rate::from_hz(*hz.get_ref()).map_err(|error| range(hz.span(), error))?;
    }
    let clock = match &file.clock.tick_us {
        Some(period) if !(1..=1_000_000).contains(period.get_ref()) => {
            return Err(text.blame(period.span(), "a fixed tick takes 1 to 1000000 µs"));
        }
        Some(period) => Clock::Tick { period: *period.get_ref() },
        None => Clock::Deadlines,
    };
    one_line(text, &file.unit)?;
    let mut plan = CyclePlan {
        strategies: file.strategies.strategies(),
        unit: file.unit.into_inner(),
        rate,
        clock,
        names: Vec::new(),
        motors: [Motor::new(1, 1); MOST],
        stands: [Stand::default(); MOST],
        positions: [0; MOST],
        placed: [false; MOST],
        pins: Vec::new(),
        at: Vec::new(),
        stages: Vec::new(),
    };
    for motor in &file.motors {
        plan.add(text, motor)?;
    }
    for cycle in file.cycles {
        let stage = plan.stage(text, cycle)?;
        plan.stages.push(stage);
    }
    Ok(plan)
}

impl CyclePlan {
    fn add(&mut self, text: &CycleText, motor: &Spanned<file::Motor>) -> Result<(), FileError> {
        let n = self.names.len();
        let at = motor.span();
        let motor = motor.get_ref();
        let (name, step) = (motor.name.get_ref(), *motor.step.get_ref());
        if n >= MOST {
            return Err(text.blame(at, format_args!("at most {MOST} motors share a timer")));
        }
        if name.is_empty() || self.names.contains(name) {
            let what = format_args!("every motor needs a name of its own, and {name:?} is none");
            return Err(text.blame(motor.name.span(), what));
        }
        one_line(text, &motor.name)?;
        if step == 0 {
            return Err(text.blame(motor.step.span(), "a step leads somewhere: 1 or more"));
        }
        let smallest = *motor.smallest_delay_us.get_ref();
        if smallest == 0 {
            let what = "a step takes some time: a smallest delay of 1 µs or more";
            return Err(text.blame(motor.smallest_delay_us.span(), what));
        }
        let max = motor.max.as_ref();
        if let (Some(min), Some(max)) = (motor.min, max)
            && min > *max.get_ref()
        {
            return Err(text.blame(max.span(), format_args!("below the minimum of {min}")));
        }
        let max = max.map(|max| *max.get_ref());
        let decel = match &motor.decel {
            Some(decel) => {
                let steps = (decel.get_ref() / f64::from(step)).round();
                if !(1.0..=f64::from(u32::MAX)).contains(&steps) {
                    let most = u64::from(step) * u64::from(u32::MAX);
                    let what = format_args!(
                        "a deceleration is 1 to 4294967295 steps/s²: {step} to {most} units/s² here"
                    );
                    return Err(text.blame(decel.span(), what));
                }
                steps as u32
            }
            None if self.strategies.hard_end.brakes() => {
                let what = format_args!("{name} is to brake at its switch: give it a decel");
                return Err(text.blame(at, what));
            }
            None => 0,
        };
        let (inverted, min) = (motor.inverted, motor.min);
        let settings = Motor { inverted, min, max, decel, ..Motor::new(step, smallest) };
        // Switches close where a position is reached, in whole steps.
        let position = motor.position.unwrap_or(0);
        let from = |at: i64| i128::from(at) - i128::from(position);
        let step = i128::from(step);
        let fit = |steps: i128| steps.clamp(i64::MIN.into(), i64::MAX.into()) as i64;
        self.stands[n] = Stand {
            min: motor.switch_min.map(|at| fit(from(at).div_euclid(step))),
            max: motor.switch_max.map(|at| fit(-(-from(at)).div_euclid(step))),
        };
        self.motors[n] = settings;
        self.positions[n] = position;
        self.placed[n] = motor.position.is_some();
        self.pins.push(Pins::read(text, motor)?);
        self.at.push(at);
        self.names.push(name.clone());
        Ok(())
    }

    /// The motor with this name.
    pub(crate) fn motor(&self, text: &CycleText, name: &Spanned<String>) -> Result<u8, FileError> {
        let found = self.names.iter().position(|known| known == name.get_ref());
        found.map(|motor| motor as u8).ok_or_else(|| {
            let (name, span) = (name.get_ref(), name.span());
            let known = match self.names.join(", ") {
                none if none.is_empty() => "nor any other".to_owned(),
                known => format!("but {known}"),
            };
            text.blame(span, format_args!("there is no motor {name:?} in this file, {known}"))
        })
    }

    /// Motors, and the positions to which they move.
    pub(crate) fn targets(
        &self,
        text: &CycleText,
        to: &file::Targets,
    ) -> Result<Vec<(u8, i64)>, FileError> {
        to.iter().map(|(name, to)| Ok((self.motor(text, name)?, *to))).collect()
    }

    /// The task of a cycle: a path, a line, an arc or homing, else moves alone.
    fn task(&self, text: &CycleText, cycle: &file::Cycle) -> Result<Task, FileError> {
        if let Some(path) = &cycle.path {
            return match (&cycle.line, &cycle.arc, &cycle.home) {
                (None, None, None) => Ok(Task::Path(Joined::read(self, text, path)?)),
                _ => Err(text.blame(path.span(), ONE)),
            };
        }
        match (&cycle.line, &cycle.arc, &cycle.home) {
            (None, None, None) => Ok(Task::Moves),
            (Some(line), None, None) => {
                let (at, line) = (line.span(), line.get_ref());
                if line.to.is_empty() {
                    return Err(text.blame(at, "a line: say where a motor is to go"));
                }
                let pace = pace(text, &line.speed, &line.accel, &line.decel, &line.jerk)?;
                Ok(Task::Line(self.targets(text, &line.to)?, pace))
            }
            (None, Some(given), None) => {
                let arc = given.get_ref();
                let [x, y] = &arc.motors;
                let motors = [self.motor(text, x)?, self.motor(text, y)?];
                if motors[0] == motors[1] {
                    return Err(text.blame(y.span(), "an arc takes two motors"));
                }
                if !arc.degrees.is_finite() {
                    return Err(text.blame(given.span(), "an arc of this many degrees has no end"));
                }
                let pace = pace(text, &arc.speed, &arc.accel, &arc.decel, &arc.jerk)?;
                Ok(Task::Arc(motors, arc.centre, arc.degrees.to_radians(), pace))
            }
            (None, None, Some(home)) => {
                let home = home.get_ref();
                let motor = self.motor(text, &home.motor)?;
                let end = if home.end == file::Side::Min { End::Min } else { End::Max };
                let homing = Homing::new(motor, end, home.reach, home.back_off);
                Ok(Task::Home(homing.delays(home.fast_us, home.slow_us)))
            }
            (_, arc, home) => {
                let span = home.as_ref().map(Spanned::span);
                let span = span.or_else(|| arc.as_ref().map(Spanned::span)).unwrap_or(0..0);
                Err(text.blame(span, ONE))
            }
        }
    }

    fn stage(&self, text: &CycleText, cycle: Spanned<file::Cycle>) -> Result<Stage, FileError> {
        let at = cycle.span();
        let mut cycle = cycle.into_inner();
        let task = self.task(text, &cycle)?;
        let mut stage =
            Stage { at: at.clone(), task, moves: Vec::new(), acts: Vec::new(), rest: 0 };
        for (name, given) in std::mem::take(&mut cycle.moves) {
            let motor = self.motor(text, &name)?;
            let at = given.span();
            let given = given.into_inner();
            let does = does(&given).map_err(|what| text.blame(at.clone(), what))?;
            let calibration = given.calibration();
            stage.moves.push(Move { motor, at, calibration, does });
        }
        match (&stage.task, stage.moves.is_empty()) {
            (Task::Moves, true) => {
                let what = "a cycle in which nothing moves: say what with `move.NAME`";
                return Err(text.blame(at, what));
            }
            (Task::Moves, false) | (_, true) => {}
            _ => return Err(text.blame(at, ONE)),
        }
        let micros = |seconds: &Option<Spanned<f64>>| match seconds {
            None => Ok(None),
            Some(s) => micros(text, s).map(Some),
        };
        let (pause, resume) = (micros(&cycle.pause_s)?, micros(&cycle.resume_s)?);
        match (pause, resume) {
            (None, Some(_)) => {
                return Err(text.blame(at, "resume-s without pause-s"));
            }
            (Some(pause), Some(resume)) if resume < pause => {
                let span = cycle.resume_s.map_or(at, |s| s.span());
                return Err(text.blame(span, "it can't be resumed before it is paused"));
            }
            _ => {}
        }
        let finish = micros(&cycle.finish_s)?;
        if matches!(stage.task, Task::Home(_)) && (pause.is_some() || finish.is_some()) {
            return Err(text.blame(at, "homing is not paused or finished"));
        }
        if let (Some(_), None, None) = (pause, resume, finish) {
            return Err(text.blame(at, "paused for ever: give resume-s or finish-s as well"));
        }
        let acts = [(pause, Act::Pause), (resume, Act::Resume), (finish, Act::Finish)];
        let timed = |(us, act): (Option<u64>, Act)| Some(TimedAct { us: us?, at: at.clone(), act });
        stage.acts = acts.into_iter().filter_map(timed).collect();
        self.changes(text, &cycle, &mut stage)?;
        stage.acts.sort_by_key(|act| act.us);
        stage.rest = micros(&cycle.rest_s)?.unwrap_or(0);
        Ok(stage)
    }

    /// Adds the changes on the way along a path to a stage.
    fn changes(
        &self,
        text: &CycleText,
        cycle: &file::Cycle,
        stage: &mut Stage,
    ) -> Result<(), FileError> {
        for given in &cycle.feed {
            let (at, feed) = (given.span(), given.get_ref());
            let us = micros(text, &feed.at_s)?;
            let scale = feed.percent.get_ref() / 100.0;
            if !SCALES.contains(&scale) {
                let (least, most) = (SCALES.start() * 100.0, SCALES.end() * 100.0);
                let what = format_args!("a feed is {least} to {most} percent of the ordered speed");
                return Err(text.blame(feed.percent.span(), what));
            }
            stage.acts.push(TimedAct { us, at, act: Act::Feed(scale) });
        }
        for given in &cycle.retarget {
            let to = &given.get_ref().to;
            let us = micros(text, &given.get_ref().at_s)?;
            let targets = self.targets(text, to.get_ref())?;
            if targets.is_empty() {
                return Err(text.blame(to.span(), "a new end: say where a motor is to go"));
            }
            if let Task::Arc(motors, ..) = &stage.task
                && !motors.iter().all(|motor| targets.iter().any(|(known, _)| known == motor))
            {
                let what = "the arc is left for a line: say where both of its motors are to go";
                return Err(text.blame(to.span(), what));
            }
            stage.acts.push(TimedAct { us, at: given.span(), act: Act::To(targets) });
        }
        let path = matches!(stage.task, Task::Line(..) | Task::Arc(..) | Task::Path(_));
        let change = |act: &&TimedAct| matches!(act.act, Act::Feed(_) | Act::To(_));
        match stage.acts.iter().find(change) {
            Some(act) if !path => {
                Err(text
                    .blame(act.at.clone(), "only along a path the feed can be changed, or the end"))
            }
            _ => Ok(()),
        }
    }
}

/// Checks that a word of the user fits in a line, a table and a picture.
fn one_line(text: &CycleText, word: &Spanned<String>) -> Result<(), FileError> {
    if word.get_ref().chars().any(char::is_control) {
        return Err(text.blame(word.span(), "one line, without control characters"));
    }
    Ok(())
}

/// A time in µs.
fn micros(text: &CycleText, seconds: &Spanned<f64>) -> Result<u64, FileError> {
    match seconds.get_ref() {
        s if (0.0..=1e6).contains(s) => Ok((s * 1e6).round() as u64),
        _ => Err(text.blame(seconds.span(), "0 to 1000000 seconds")),
    }
}

/// The speed and the accelerations along a path.
fn pace(
    text: &CycleText,
    speed: &Spanned<f64>,
    accel: &Spanned<f64>,
    decel: &Option<Spanned<f64>>,
    jerk: &Option<Spanned<f64>>,
) -> Result<Pace, FileError> {
    let mut pace = Pace::new(1.0, 1.0);
    let mut check = |value: &Spanned<f64>, of: fn(&mut Pace) -> &mut f64| {
        *of(&mut pace) = *value.get_ref();
        // Infinite is the value for no jerk; a file must not order it.
        let known = value.get_ref().is_finite().then_some(()).ok_or(Unplannable::Jerk);
        pace.check().and(known).map_err(|error| text.blame(value.span(), error))
    };
    check(speed, |pace| &mut pace.speed)?;
    check(accel, |pace| &mut pace.accel)?;
    check(decel.as_ref().unwrap_or(accel), |pace| &mut pace.decel)?;
    jerk.iter().try_for_each(|jerk| check(jerk, |pace| &mut pace.jerk))?;
    Ok(pace)
}

/// The move that a file orders of a motor, or what is wrong with it.
fn does(given: &file::Move) -> Result<Does, String> {
    let ways = [
        given.steps.is_some(),
        given.whirl.is_some(),
        given.series.is_some(),
        given.delays_us.is_some(),
    ];
    if ways.iter().filter(|given| **given).count() != 1 {
        return Err("say one of steps, whirl, series and delays-us".into());
    }
    let only = |what: &str, given: bool| match given {
        true => Err(format!("{what} does not belong here")),
        false => Ok(()),
    };
    only("each", given.each.is_some() && given.delays_us.is_none())?;
    only("direction", given.direction.is_some() && given.delays_us.is_none())?;
    let simple = given.steps.is_some() || given.whirl.is_some();
    only("delay-us", given.delay_us.is_some() && (!simple || given.ramp_us.is_some()))?;
    only("ramp-us", given.ramp_us.is_some() && !simple)?;
    let delay = given.delay_us.unwrap_or(0);
    let forward = |way: Option<Way>| way != Some(Way::Backward);
    if let Some(ramp) = given.ramp_us {
        let way = given.steps.map_or(forward(given.whirl), |count| count >= 0);
        return Ok(Does::Ramp(given.steps.map(i32::unsigned_abs), way, ramp.into()));
    }
    if let Some(steps) = given.steps {
        return Ok(Does::Steps(steps, delay));
    }
    if let Some(way) = given.whirl {
        return Ok(Does::Whirl(way == Way::Forward, delay));
    }
    if let Some(delays) = &given.delays_us {
        return Ok(Does::List(delays.clone(), given.each.unwrap_or(1), forward(given.direction)));
    }
    let legs = given.series.iter().flatten().map(|leg| match (leg.steps, &leg.wait) {
        (Some(count), None) => Ok(Leg::Steps { count, delay: leg.delay_us }),
        (None, Some(count)) => Ok(Leg::Wait { count: *count.get_ref(), delay: leg.delay_us }),
        _ => Err("a leg of a series has either steps or wait".to_owned()),
    });
    Ok(Does::Series(legs.collect::<Result<_, _>>()?))
}
