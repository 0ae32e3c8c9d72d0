//! The steps of a job: G-code through a [`Route`], read only as far as steps are asked for.
//!
//! ```text
//!   bytes ─► Reader ─► effects ─┬─ a move ──► ArcFit ─► line_to, arc ─► Route ─► steps, or stretches
//!                               └─ a dwell, a change of spindle or coolant, a pause:
//!                                  at rest where the route ends
//! ```
//!
//! With G64 P the path may be off its lines by a tolerance. Lines that one arc or one line may replace wait
//! in [`ArcFit`].
//!
//! With a laser M3, M4, M5 and S are properties of the moves after them. The route does not stop for them.
//!
//! The job reads no more than the route asks for. The memory of a job of any length is that of the moves
//! ahead of its steps.

use std::collections::VecDeque;
use std::fmt;

use stepwright_gcode::{Effect, Error, Length, Options, Reader, Spindle, Stop};
use stepwright_path::{
    ArcFit, AxisPace, LaserMove, Route, RouteStep, StepSource, Stretch, Unplannable, decimal, mm,
};

use super::laser::LaserSignal;
use super::{JobSurvey, PowerChange};

/// Why a job ends early.
#[derive(Clone, Debug, PartialEq)]
pub enum JobError {
    /// A line that can't be read.
    Code(Error),
    /// A move in this line that can't be planned.
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

/// The settings of a job beside its text.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JobTerms {
    /// A [laser](GcodeJob::with_laser) instead of a spindle; full power at this S.
    pub laser: Option<f64>,
    /// How far the path may be [off its lines](GcodeJob::with_tolerance).
    pub tolerance: Length,
}

/// A move ahead.
#[derive(Clone, Copy, Debug)]
struct End {
    /// The place along the route where it ends.
    way: f64,
    line: u32,
    laser: LaserMove,
}

/// A running G-code job of the axes X, Y and Z in millimetres.
///
/// Rapid moves are as fast as the axes can go. The spindle and the coolant change at rest, as in grbl
/// without laser mode. The job does not wait for a person (M0, M1) or a probe: a probing move goes to its end.
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
    fit: ArcFit<(u32, LaserMove), 3>,
    route: Route<3>,
    survey: JobSurvey,
    todo: VecDeque<(u32, Effect)>,
    /// The moves ahead in their order.
    ends: VecDeque<End>,
    spindle: Spindle,
    laser: Option<LaserSignal>,
    error: Option<JobError>,
    /// Nothing more has to be read.
    read: bool,
}

impl<B: Iterator<Item = u8>> GcodeJob<B> {
    /// A job that starts at rest at the machine's zero.
    ///
    /// # Errors
    /// [`Unplannable`] for these axes.
    pub fn new(
        bytes: impl IntoIterator<Item = u8, IntoIter = B>,
        axes: [AxisPace; 3],
    ) -> Result<GcodeJob<B>, Unplannable> {
        Ok(GcodeJob {
            bytes: bytes.into_iter(),
            reader: Reader::new(Options::default()),
            fit: ArcFit::new(0.0)?,
            route: Route::new(axes)?,
            survey: JobSurvey::default(),
            todo: VecDeque::new(),
            ends: VecDeque::new(),
            spindle: Spindle::default(),
            laser: None,
            error: None,
            read: false,
        })
    }

    /// Sets a laser instead of a spindle, with its full power at S = `most`. M3, M4, M5 and S change the
    /// laser from the next move on, and the path goes on at speed. [`power`](GcodeJob::power) then gives a
    /// signal beside the steps.
    ///
    /// ```
    /// use stepwright_path::AxisPace;
    /// use stepwright_plan::gcode::GcodeJob;
    /// let axis = AxisPace { step: 0.0125, speed: 200.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
    /// let job = *b"M4 S500 G1 F3000 X10\nS1000 X20\n";
    /// let mut job = GcodeJob::new(job, [axis; 3]).unwrap().with_laser(1_000.0);
    /// let mut most: f64 = 0.0;
    /// while let Some(step) = job.step()? {
    ///     while let Some(change) = job.power(step.time) {
    ///         most = most.max(change.power);
    ///     }
    /// }
    /// assert_eq!(most, 1.0);
    /// // It is off at rest.
    /// let last = std::iter::from_fn(|| job.power(9.0)).last().unwrap();
    /// assert_eq!((last.time, last.power), (job.time(), 0.0));
    /// # Ok::<(), stepwright_plan::gcode::JobError>(())
    /// ```
    pub fn with_laser(mut self, most: f64) -> GcodeJob<B> {
        self.route = self.route.with_glides();
        self.laser = Some(LaserSignal::new(most));
        self
    }

    /// Sets the tolerance: the path may be that far off its lines until the job orders G61 or G64. One line
    /// or one arc replaces as many short lines as it fits. Without this call the path is exact.
    ///
    /// The first move refuses a negative tolerance with [`Unplannable::Tolerance`].
    ///
    /// ```
    /// use stepwright_gcode::Length;
    /// use stepwright_path::AxisPace;
    /// use stepwright_plan::gcode::GcodeJob;
    /// let axis = AxisPace { step: 0.0125, speed: 200.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
    /// // A circle of 20 mm in chords of 0.1 mm, with places of two digits.
    /// let text = (0..=1_257).fold("G1 F6000\n".to_owned(), |text, n| {
    ///     let (sin, cos) = (f64::from(n) * 0.005).sin_cos();
    ///     text + &format!("X{:.2} Y{:.2}\n", 20.0 * sin, 20.0 - 20.0 * cos)
    /// });
    /// let time = |tolerance| {
    ///     let job = GcodeJob::new(text.bytes(), [axis; 3]).unwrap();
    ///     let mut job = job.with_tolerance(tolerance);
    ///     while job.step().unwrap().is_some() {}
    ///     job.time()
    /// };
    /// // 10 µm.
    /// let near = Length::from_picometres(10_000_000).unwrap();
    /// assert!(time(near) < 0.5 * time(Length::ZERO));
    /// ```
    pub fn with_tolerance(mut self, tolerance: Length) -> GcodeJob<B> {
        self.reader = Reader::new(Options { tolerance, ..Options::default() });
        self
    }

    /// A job with these settings.
    ///
    /// # Errors
    /// As for [`new`](GcodeJob::new).
    pub fn on(
        bytes: impl IntoIterator<Item = u8, IntoIter = B>,
        axes: [AxisPace; 3],
        terms: &JobTerms,
    ) -> Result<GcodeJob<B>, Unplannable> {
        let job = GcodeJob::new(bytes, axes)?.with_tolerance(terms.tolerance);
        Ok(terms.laser.into_iter().fold(job, GcodeJob::with_laser))
    }

    /// The next step. `None` at the end of the job, and while it [is held](GcodeJob::is_held).
    ///
    /// # Errors
    /// [`JobError`] after all steps before the error: the job ends at rest there.
    pub fn step(&mut self) -> Result<Option<RouteStep>, JobError> {
        loop {
            if let Some(step) = self.route.next() {
                return Ok(Some(step));
            }
            if self.laser.is_none() {
                // Nobody asks for the lines of the moves.
                self.ends.clear();
            }
            if self.route.is_held() || !self.more()? {
                return Ok(None);
            }
        }
    }

    /// The next part of the way without its steps, and the line of its move. `None` at the end.
    ///
    /// # Errors
    /// As for [`step`](GcodeJob::step).
    pub fn stretch(&mut self) -> Result<Option<(u32, Stretch<3>)>, JobError> {
        loop {
            if let Some(stretch) = self.route.pass_over() {
                self.reach(stretch.way[1]);
                return Ok(Some((self.ends.front().map_or(0, |end| end.line), stretch)));
            }
            if !self.more()? {
                return Ok(None);
            }
        }
    }

    /// The next change of the laser's power up to `until`, in s: no later than the last step, unless the
    /// job stands or is over. The job keeps all changes that are not taken. `None` as well without a
    /// [laser](GcodeJob::with_laser).
    ///
    /// The laser is off at first. A change holds until the next one. While the speed changes, the power of
    /// M4 is within [`POWER_WITHIN`](super::POWER_WITHIN) of S in proportion to the speed.
    pub fn power(&mut self, until: f64) -> Option<PowerChange> {
        loop {
            let laser = self.laser.as_mut()?;
            if let Some(change) = laser.changes.pop_front() {
                return Some(change);
            }
            let glide = self.route.glide(until)?;
            self.reach(glide.within);
            let along = self.laser_move();
            self.laser.as_mut()?.follow(&glide, along);
        }
    }

    /// What the laser does along the last [`stretch`](GcodeJob::stretch).
    pub fn laser_move(&self) -> LaserMove {
        self.ends.front().map_or(LaserMove::default(), |end| end.laser)
    }

    /// Removes moves that end before this place. A cell ends exactly where its move ends.
    fn reach(&mut self, way: f64) {
        while self.ends.len() > 1 && self.ends[0].way < way {
            self.ends.pop_front();
        }
    }

    /// Brakes along the way as soon as possible. The rest of the job is dropped.
    pub fn cancel(&mut self) {
        self.cancel_at(0.0);
    }

    /// Brakes along the way as [`cancel`](GcodeJob::cancel), but not before this time in s.
    pub fn cancel_at(&mut self, at: f64) {
        (self.read, self.error) = (true, None);
        self.todo.clear();
        self.fit.clear();
        self.route.cancel(at);
    }

    /// Brakes along the way, not before this time in s, and stands there.
    pub fn hold_at(&mut self, at: f64) {
        self.route.hold(at);
    }

    /// Goes on at this time in s, or as soon as the job stands.
    pub fn resume_at(&mut self, at: f64) {
        self.route.resume(at);
    }

    /// Whether the job stands because it is held: it has no step until it is resumed.
    pub fn is_held(&self) -> bool {
        self.route.is_held()
    }

    /// Seconds from the start to the end of the steps so far, with dwells.
    pub fn time(&self) -> f64 {
        self.route.time()
    }

    /// The survey of the part that has been read.
    pub fn survey(&self) -> &JobSurvey {
        &self.survey
    }

    /// Gives the route more to plan. False if there is nothing more.
    fn more(&mut self) -> Result<bool, JobError> {
        loop {
            let Some((line, effect)) = self.todo.pop_front() else {
                if !self.read {
                    self.read_block();
                } else if self.fit.waiting() > 0 {
                    self.settle();
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
                    let (spindle, route) = (self.spindle, &mut self.route);
                    let tag = |feed| (line, LaserMove::new(&part, spindle, feed));
                    if let Err(why) = self.fit.travel(route, &part, tag) {
                        self.fail(JobError::Move(line, why));
                    }
                    if self.settled() {
                        return Ok(true);
                    }
                    continue;
                }
                Effect::Spindle(ordered) if self.laser.is_some() => {
                    self.settle();
                    self.spindle = ordered;
                    continue;
                }
                Effect::Dwell(seconds) => decimal(seconds),
                Effect::Stop(Stop::OptionalPause) => continue,
                Effect::Spindle(_) | Effect::Coolant(_) | Effect::Stop(_) => 0.0,
                _ => continue,
            };
            self.settle();
            if !self.route.dwell(rest) {
                self.todo.push_front((line, effect));
                self.route.close();
                return Ok(true);
            }
        }
    }

    /// Gives the waiting lines to the route.
    fn settle(&mut self) {
        if let Err(why) = self.fit.settle(&mut self.route) {
            self.fail(JobError::Move(self.survey.lines, why));
        }
        self.settled();
    }

    /// Records the ends of the moves that the route has got. Returns whether there are any.
    fn settled(&mut self) -> bool {
        let before = self.ends.len();
        while let Some((way, (line, laser))) = self.fit.settled() {
            self.ends.push_back(End { way, line, laser });
        }
        self.ends.len() > before
    }

    /// Ends the job after the moves that have been read.
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
                // Everything in the lines before this one is done.
                let tolerance = mm(self.reader.modal().tolerance);
                if let Err(why) = self.fit.set_tolerance(&mut self.route, tolerance) {
                    return self.fail(JobError::Move(block.line, why));
                }
                self.settled();
                self.todo.extend(block.effects().map(|effect| (block.line, effect)));
            }
            Some(Err(error)) => self.fail(JobError::Code(error)),
            None => {}
        }
    }
}

/// The steps of a job that was read to its end before without an error. An error ends it.
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
