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

use std::collections::VecDeque;
use std::fmt;

use stepwright_gcode::{Effect, Error, Options, Reader, Stop};
use stepwright_path::{AxisPace, Route, RouteStep, StepSource, Stretch, Unplannable};

use super::{JobSurvey, number};

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
/// let axis = AxisPace { step: 0.0125, speed: 200.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
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
            survey: JobSurvey::default(),
            todo: VecDeque::new(),
            ends: VecDeque::new(),
            error: None,
            read: false,
        })
    }

    /// The next step; `None` at the end of the job, and while it [is held](GcodeJob::is_held).
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
            if self.route.is_held() || !self.more()? {
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
        self.cancel_at(0.0);
    }

    /// Likewise, but not before this time, in s.
    pub fn cancel_at(&mut self, at: f64) {
        (self.read, self.error) = (true, None);
        self.todo.clear();
        self.route.cancel(at);
    }

    /// Brakes along its way, not before this time, in s, and stands there.
    pub fn hold_at(&mut self, at: f64) {
        self.route.hold(at);
    }

    /// Goes on at this time, in s, or once it stands.
    pub fn resume_at(&mut self, at: f64) {
        self.route.resume(at);
    }

    /// Whether it stands because it is held: it has no step until it is resumed.
    pub fn is_held(&self) -> bool {
        self.route.is_held()
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
                    if let Err(why) = self.route.travel(&part) {
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
}

/// The steps of a job that was read before to its end without an error: at one it is over.
impl<B: Iterator<Item = u8>> StepSource for GcodeJob<B> {
    fn next_step(&mut self) -> Option<RouteStep> {
        self.step().ok().flatten()
    }

    fn duration(&self) -> f64 {
        self.time()
    }

    fn is_held(&self) -> bool {
        GcodeJob::is_held(self)
    }
}
