//! A job's steps: G-code through a [`Route`], as far as it is asked for.
//!
//! ```text
//!   bytes ─► Reader ─► effects ─┬─ a move ──► line_to, arc ─► Route ─► steps, or stretches
//!                               └─ a dwell, a change of spindle or coolant, a pause:
//!                                  at rest where the route ends
//! ```
//!
//! No more is read than the route asks for, so a job of any length takes the memory of what lies
//! ahead of its steps.
//!
//! An arc whose ends are not equally far from its centre, because their digits are rounded, is
//! divided into quarters from one radius to the other, each around the centre that fits both of
//! its ends: it leads to its exact end, and its direction changes by a part of the difference.

use std::collections::VecDeque;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt;

use stepwright_gcode::{Arc, Effect, Error, FeedRate, Move, MoveKind, Options, Reader, Stop};
use stepwright_path::{AxisPace, Route, RouteStep, StepSource, Stretch, Unplannable};

use super::{JobSurvey, length, millimetres, number};

/// Why a job can't go on.
#[derive(Clone, Debug, PartialEq)]
pub enum JobError {
    /// A line that can't be read.
    Code(Error),
    /// A move that can't be planned, in this line.
    Move(u32, Unplannable),
}

impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            JobError::Code(error) => error.fmt(f),
            JobError::Move(line, why) => write!(f, "line {line}: {why}"),
        }
    }
}

impl std::error::Error for JobError {}

/// A G-code job in motion, of the axes X, Y and Z in millimetres.
///
/// Rapid moves go as fast as the axes can. The spindle and the coolant change at rest, as grbl has
/// it without laser mode; what waits for somebody (M0, M1) or for a probe is not waited for, and a
/// probing move leads to its end.
///
/// ```
/// use stepwright_path::AxisPace;
/// use stepwright_plan::gcode::GcodeJob;
/// let axis = AxisPace { step: 0.0125, speed: 200.0, accel: 1_000.0, jump: 5.0 };
/// let mut job = GcodeJob::new(*b"G1 F3000 X10\nG3 X20 Y10 J10\nG4 P0.5\nG1 X0 Y0\n", [axis; 3]).unwrap();
/// let mut at = [0; 3];
/// while let Some(step) = job.step()? {
///     at[step.axis] += if step.forward { 1 } else { -1 };
/// }
/// assert_eq!(at, [0; 3]);
/// # Ok::<(), stepwright_plan::gcode::JobError>(())
/// ```
#[derive(Clone, Debug)]
pub struct GcodeJob<B> {
    bytes: B,
    reader: Reader,
    route: Route<3>,
    fastest: [f64; 3],
    /// Arcs of a smaller radius are lines.
    least: f64,
    survey: JobSurvey,
    todo: VecDeque<(u32, Effect)>,
    /// Where the moves ahead end along the route, and their lines.
    ends: VecDeque<(f64, u32)>,
    error: Option<JobError>,
    /// Nothing more is read.
    read: bool,
}

impl<B: Iterator<Item = u8>> GcodeJob<B> {
    /// A job from the machine's zero, at rest.
    ///
    /// # Errors
    /// [`Unplannable`], of the axes.
    pub fn new(
        bytes: impl IntoIterator<Item = u8, IntoIter = B>,
        axes: [AxisPace; 3],
    ) -> Result<GcodeJob<B>, Unplannable> {
        Ok(GcodeJob {
            bytes: bytes.into_iter(),
            reader: Reader::new(Options::default()),
            route: Route::new(axes)?,
            fastest: axes.map(|axis| axis.speed),
            least: axes.map(|axis| axis.step).into_iter().fold(0.0, f64::max),
            survey: JobSurvey::default(),
            todo: VecDeque::new(),
            ends: VecDeque::new(),
            error: None,
            read: false,
        })
    }

    /// The next step; `None` at the end of the job.
    ///
    /// # Errors
    /// [`JobError`] when all steps before it are made: the job ends at rest there.
    pub fn step(&mut self) -> Result<Option<RouteStep>, JobError> {
        loop {
            if let Some(step) = self.route.next() {
                return Ok(Some(step));
            }
            // Nobody asks for them.
            self.ends.clear();
            if !self.more()? {
                return Ok(None);
            }
        }
    }

    /// The next part of the way without its steps, and the line of its move; `None` at the end.
    ///
    /// # Errors
    /// As for [`step`](GcodeJob::step).
    pub fn stretch(&mut self) -> Result<Option<(u32, Stretch<3>)>, JobError> {
        loop {
            if let Some(stretch) = self.route.pass_over() {
                // A cell ends where its move does, to the last digit.
                while self.ends.len() > 1 && self.ends[0].0 < stretch.way[1] {
                    self.ends.pop_front();
                }
                return Ok(Some((self.ends.front().map_or(0, |end| end.1), stretch)));
            }
            if !self.more()? {
                return Ok(None);
            }
        }
    }

    /// Brakes as soon as it can, along its way; what is left of it is not made.
    pub fn cancel(&mut self) {
        (self.read, self.error) = (true, None);
        self.todo.clear();
        self.route.cancel(0.0);
    }

    /// Seconds from the start to the end of what has been made, dwells included.
    pub fn time(&self) -> f64 {
        self.route.time()
    }

    /// What has been read of it.
    pub fn survey(&self) -> &JobSurvey {
        &self.survey
    }

    /// Gives the route more to plan. False: there is nothing more.
    fn more(&mut self) -> Result<bool, JobError> {
        loop {
            let Some((line, effect)) = self.todo.pop_front() else {
                if !self.read {
                    self.read_block();
                } else if self.route.is_over() {
                    return self.error.take().map_or(Ok(false), Err);
                } else {
                    self.route.close();
                    return Ok(true);
                }
                continue;
            };
            let rest = match effect {
                Effect::Move(part) => {
                    if let Err(why) = self.travel(&part) {
                        self.fail(JobError::Move(line, why));
                        continue;
                    }
                    self.ends.push_back((self.route.length(), line));
                    return Ok(true);
                }
                Effect::Dwell(seconds) => number(seconds),
                Effect::Stop(Stop::OptionalPause) => continue,
                Effect::Spindle(_) | Effect::Coolant(_) | Effect::Stop(_) => 0.0,
                _ => continue,
            };
            if !self.route.dwell(rest) {
                self.todo.push_front((line, effect));
                self.route.close();
                return Ok(true);
            }
        }
    }

    /// The job ends with what has been read.
    fn fail(&mut self, error: JobError) {
        (self.read, self.error) = (true, Some(error));
        self.todo.clear();
    }

    fn read_block(&mut self) {
        let block = loop {
            match self.bytes.next() {
                Some(byte) => {
                    if let Some(block) = self.reader.push(byte) {
                        break Some(block);
                    }
                }
                None => {
                    self.read = true;
                    break self.reader.finish();
                }
            }
        };
        match block {
            Some(Ok(block)) => {
                self.survey.add(&block);
                self.todo.extend(block.effects().map(|effect| (block.line, effect)));
            }
            Some(Err(error)) => self.fail(JobError::Code(error)),
            None => {}
        }
    }

    fn travel(&mut self, part: &Move) -> Result<(), Unplannable> {
        let (from, to) = (millimetres(part.from), millimetres(part.to));
        let way: [f64; 3] = std::array::from_fn(|axis| to[axis] - from[axis]);
        let distance = way.into_iter().fold(0.0, f64::hypot);
        match part.kind {
            MoveKind::Rapid => {
                let each = way.iter().zip(&self.fastest).filter(|(way, _)| **way != 0.0);
                let fastest = each.map(|(way, speed)| speed / way.abs());
                self.route.line_to(to, fastest.fold(f64::MAX, f64::min) * distance)
            }
            MoveKind::Feed(rate) | MoveKind::Probe(_, rate) => {
                self.route.line_to(to, per_second(rate, distance))
            }
            MoveKind::Arc(arc, rate) => self.round(arc, from, to, rate),
        }
    }

    fn round(
        &mut self,
        arc: Arc,
        from: [f64; 3],
        to: [f64; 3],
        rate: FeedRate,
    ) -> Result<(), Unplannable> {
        let [first, second, third] = arc.plane.axes();
        let centre = arc.centre.map(length);
        let spoke = |end: [f64; 3]| [end[first] - centre[0], end[second] - centre[1]];
        let ends = [spoke(from), spoke(to)];
        let radii = ends.map(|[x, y]| x.hypot(y));
        let [begin, stop] = ends.map(|[x, y]| y.atan2(x));
        let turn = if arc.clockwise { begin - stop } else { stop - begin }.rem_euclid(TAU);
        let closed = from[first] == to[first] && from[second] == to[second];
        let turn = if closed { TAU } else { turn };
        let sign = if arc.clockwise { -1.0 } else { 1.0 };
        let (rise, radius) = (to[third] - from[third], (radii[0] + radii[1]) / 2.0);
        let feed = per_second(rate, (radius * turn).hypot(rise));
        if !(radii[0].min(radii[1]) > self.least && turn > 0.0) {
            return self.route.line_to(to, feed);
        }
        let mut climb = [0.0; 3];
        if (radii[1] - radii[0]).abs() <= EQUAL {
            climb[third] = rise;
            return self.route.arc([first, second], centre, sign * turn, climb, feed);
        }
        let parts = (turn / FRAC_PI_2).ceil();
        climb[third] = rise / parts;
        let mut a = [from[first], from[second]];
        for part in 1..=parts as u32 {
            let share = f64::from(part) / parts;
            let b = if share < 1.0 {
                let angle = begin + sign * turn * share;
                let radius = radii[0] + (radii[1] - radii[0]) * share;
                [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()]
            } else {
                [to[first], to[second]]
            };
            // The point that is as far from both, nearest to the centre.
            let way = [b[0] - a[0], b[1] - a[1]];
            let chord = way[0].hypot(way[1]);
            let ahead = [0, 1].map(|n| centre[n] - (a[n] + b[n]) / 2.0);
            let off = (ahead[0] * way[0] + ahead[1] * way[1]) / chord / chord;
            let fitted = [0, 1].map(|n| centre[n] - off * way[n]);
            let radius = (fitted[0] - a[0]).hypot(fitted[1] - a[1]);
            let sweep = 2.0 * (chord / 2.0 / radius).min(1.0).asin();
            self.route.arc([first, second], fitted, sign * sweep, climb, feed)?;
            a = b;
        }
        Ok(())
    }
}

/// Radii that differ by less, in mm, are equal: what a centre that is given by a radius is
/// rounded by.
const EQUAL: f64 = 1e-8;

fn per_second(rate: FeedRate, distance: f64) -> f64 {
    match rate {
        FeedRate::PerMinute(rate) => length(rate) / 60.0,
        FeedRate::Inverse(moves) => distance * number(moves) / 60.0,
    }
}

/// The steps of a job that was read before to its end without an error: at one it is over.
impl<B: Iterator<Item = u8>> StepSource for GcodeJob<B> {
    fn next_step(&mut self) -> Option<RouteStep> {
        self.step().ok().flatten()
    }

    fn duration(&self) -> f64 {
        self.time()
    }
}
