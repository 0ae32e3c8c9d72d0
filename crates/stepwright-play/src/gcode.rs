//! Plays a G-code job on the virtual board, which has the timer and the step costs of an Uno.
//!
//! ```
//! use stepwright_path::AxisPace;
//! use stepwright_plan::gcode::JobPlan;
//! use stepwright_play::stream::{PlayEnd, PlayOrder};
//! use stepwright_play::{PlayError, gcode};
//! use stepwright_sim::{Description, Edge};
//!
//! let axis = AxisPace { step: 0.0125, speed: 200.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
//! let job = b"G0 X10\nG1 F600 X12 Y3\n";
//! let plan = JobPlan::of(*job, [axis; 3], &Description::uno().board, |_, _| ()).unwrap();
//! let end = gcode::begin(job.to_vec(), [axis; 3], &plan, |_| Ok(Vec::<Edge>::new()), |mut begun| {
//!     let end = begun.play(true, &mut &PlayOrder::default(), |_, _| ())?;
//!     assert_eq!(end, PlayEnd::Done);
//!     Ok::<_, PlayError>(begun.positions())
//! });
//! assert_eq!(end?, [960, 240, 0]);
//! # Ok::<(), PlayError>(())
//! ```

use std::fmt::Display;
use std::thread;
use std::time::{Duration, Instant};
use std::vec::IntoIter;

use stepwright::{Rate, Ticks};
use stepwright_cycle::{Calibration, Clock, Motor, Program};
use stepwright_path::{AxisPace, Stream};
use stepwright_plan::gcode::{GcodeJob, JobPlan};
use stepwright_sim::{CycleBoard, Description, Recorder, Stand};

use crate::PlayError;
use crate::stream::{JobWatch, Obeyed, Place, PlayEnd, PlayWish, REPORT};

/// The virtual board's name in messages.
pub const BOARD: &str = "An Uno";

/// The names of a job's axes.
pub const NAMES: [&str; 3] = ["X", "Y", "Z"];

/// The most events of one [`pass`](BegunJob::pass).
const EVENTS: u32 = 10_000;

/// The time between two checks of the clock.
const LOOK: Duration = Duration::from_millis(2);

/// The board of a job.
pub type GcodeBoard<'a, R> = CycleBoard<'a, R, 3>;

/// A change of the laser's power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lit {
    /// The tick of the board from which it counts.
    pub time: u64,
    /// The power from 0, off, to 1.
    pub power: f64,
}

/// A job that has begun.
pub struct BegunJob<'a, 'b, R: Recorder> {
    lit: Option<Vec<Lit>>,
    stream: &'a Stream<GcodeJob<IntoIter<u8>>, 3>,
    /// The board that plays it.
    pub board: &'a mut GcodeBoard<'b, R>,
    /// Ticks of the board in a second.
    pub rate: Rate,
    /// Ticks from the board's start to that of the path.
    pub lead: Ticks,
    /// The tick at which the board began.
    pub from: u64,
    /// The tick at which the path begins, `lead` later.
    pub path: u64,
}

/// Begins a job that has been planned and admitted, on the terms of its plan. `go` lets the board's
/// time pass. `recorder` makes the recorder of the pins' edges.
///
/// # Errors
/// [`PlayError`] if the axes can't be planned, or the board refuses them; the errors of `recorder`
/// and `go`.
pub fn begin<T, R: Recorder, E: From<PlayError>>(
    job: Vec<u8>,
    axes: [AxisPace; 3],
    plan: &JobPlan,
    recorder: impl FnOnce(Rate) -> Result<R, E>,
    go: impl FnOnce(BegunJob<R>) -> Result<T, E>,
) -> Result<T, E> {
    let refused = |why: &dyn Display| PlayError::new(why.to_string());
    let board = Description::uno().board;
    let rate = board.rate;
    let job = GcodeJob::on(job, axes, &plan.terms);
    let job = job.map_err(|why| refused(&format_args!("the axes: {why}")))?;
    let lit = plan.laser.map(|_| Vec::new());
    let delays = plan.delays();
    let shortest = delays.map(|delay| rate.micros(delay.unwrap_or(0)));
    // The first step comes no sooner than the shortest interval between steps permits.
    let lead = shortest.into_iter().fold(board.lead, Ticks::max);
    let (stream, mut steps) = Stream::new(job, rate, lead, shortest);
    let recorder = recorder(rate)?;
    let motors = delays.map(|delay| Motor::new(1, delay.unwrap_or(1)));
    let stands = [Stand::default(); 3];
    let mut board = CycleBoard::new(motors, stands, Clock::Deadlines, rate, recorder);
    for ((axis, steps), _) in (0..).zip(&mut steps).zip(delays).filter(|(_, d)| d.is_some()) {
        let prepared = board.cycle().prepare(axis, Program::Paced(steps), Calibration::None);
        prepared.map_err(|why| refused(&why))?;
    }
    // A job with only dwells has nothing to start.
    if delays.iter().any(Option::is_some) {
        board.cycle().start().map_err(|why| refused(&why))?;
    }
    let from = board.now();
    let path = from + u64::from(lead);
    go(BegunJob { lit, stream: &stream, board: &mut board, rate, lead, from, path })
}

impl<'b, R: Recorder> BegunJob<'_, 'b, R> {
    /// Whether the job is running.
    pub fn is_running(&mut self) -> bool {
        self.board.cycle().is_running()
    }

    /// Brakes along the path, and drops the rest of the job.
    pub fn brake(&self) {
        self.stream.look(GcodeJob::cancel);
    }

    /// Brakes along the path, and waits for [`resume`](BegunJob::resume).
    pub fn hold(&self) {
        self.stream.change(|job, made| job.hold_at(made));
    }

    /// Resumes after a hold.
    pub fn resume(&self) {
        self.stream.change(|job, made| job.resume_at(made));
    }

    /// Lets the board's time pass until the job ends: in real time, or as fast as it can be
    /// simulated. `watch` controls it and hears of the progress. Calls `seen` after each event,
    /// like [`pass`](BegunJob::pass). Returns how it ended; a killed job is left as it is.
    ///
    /// # Errors
    /// [`PlayError`] if the board has ended the job.
    pub fn play(
        &mut self,
        fast: bool,
        watch: &mut dyn JobWatch,
        mut seen: impl FnMut(&mut GcodeBoard<'b, R>, &[Lit]),
    ) -> Result<PlayEnd, PlayError> {
        let (hz, begun) = (f64::from(self.rate.hz()), Instant::now());
        let (mut obeyed, mut told) = (Obeyed::default(), None::<Instant>);
        while self.is_running() {
            let wish = watch.wish();
            if wish == PlayWish::Kill {
                break;
            }
            let changes = wish != obeyed.wish && obeyed.wish < PlayWish::Brake;
            if changes {
                match wish {
                    PlayWish::Hold => self.hold(),
                    PlayWish::Go => self.resume(),
                    PlayWish::Brake | PlayWish::Kill => self.brake(),
                }
                obeyed = obeyed.then(wish, self.passed() as f64 / hz);
            }
            let limit = match fast {
                true => u64::MAX,
                false => self.from + (begun.elapsed().as_secs_f64() * hz) as u64,
            };
            let more = self.pass(limit, &mut seen);
            if changes || told.is_none_or(|told| told.elapsed() >= REPORT) {
                told = Some(Instant::now());
                watch.tell(&self.place(obeyed));
            }
            if !more && self.is_running() {
                thread::sleep(LOOK);
            }
        }
        watch.tell(&self.place(obeyed));
        self.checked()?;
        Ok(match (self.is_running(), obeyed.wish) {
            (true, _) => PlayEnd::Killed,
            (false, PlayWish::Brake) => PlayEnd::Stopped,
            (false, _) => PlayEnd::Done,
        })
    }

    /// The progress, with the wish that it obeys.
    fn place(&mut self, obeyed: Obeyed) -> Place {
        let passed = self.passed() as f64 / f64::from(self.rate.hz());
        let (seconds, steps) = (obeyed.without_holds(passed), self.positions());
        Place { seconds, steps, wish: obeyed.wish }
    }

    /// Lets the board's time pass to `limit` ticks, or for a limited number of events. Calls `seen`
    /// after each event, with the changes of the laser's power since the event before. Returns
    /// false if nothing more happens before `limit`.
    pub fn pass(
        &mut self,
        limit: u64,
        mut seen: impl FnMut(&mut GcodeBoard<'b, R>, &[Lit]),
    ) -> bool {
        for _ in 0..EVENTS {
            let more = self.board.pass(limit);
            self.look_at_laser();
            seen(self.board, self.lit.as_deref().unwrap_or_default());
            if !more || !self.is_running() {
                return false;
            }
        }
        true
    }

    /// Collects the changes of the laser's power up to now.
    fn look_at_laser(&mut self) {
        let (hz, from, passed) = (f64::from(self.rate.hz()), self.path, self.passed());
        let (now, over) = (self.board.now(), !self.is_running());
        let Some(lit) = &mut self.lit else { return };
        lit.clear();
        self.stream.look(|job| {
            // The path may end a fraction of a tick after the board. The laser is off from there
            // on.
            let end = if over { job.time() + 1.0 / hz } else { 0.0 };
            let until = end.max(passed as f64 / hz);
            while let Some(change) = job.power(until) {
                let time = (from + (change.time * hz).round() as u64).min(now);
                lit.push(Lit { time, power: change.power });
            }
        });
    }

    /// The axes' positions in steps.
    pub fn positions(&mut self) -> [i64; 3] {
        let cycle = self.board.cycle();
        [0, 1, 2].map(|axis| cycle.position(axis).unwrap_or(0))
    }

    /// The time since the start of the path, in ticks.
    pub fn passed(&self) -> u64 {
        self.board.now().saturating_sub(self.path)
    }

    /// Checks whether the board has ended the job.
    ///
    /// # Errors
    /// [`PlayError`]: the reason.
    pub fn checked(&mut self) -> Result<(), PlayError> {
        match self.board.cycle().error() {
            Some(error) => Err(PlayError::new(format!("the board has ended the job: {error}"))),
            None => Ok(()),
        }
    }
}
