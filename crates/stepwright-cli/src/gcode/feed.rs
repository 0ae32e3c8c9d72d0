//! A job on a board that plays streams: its steps are planned here and sent as they are needed.
//!
//! ```text
//!   wish ─► cut: what was sent ahead is taken back, and the plan goes on from there
//!   job ─► steps ─► feeder ─► line ─► board
//!            └─ where the board is by now ─► told
//! ```

use std::time::{Duration, Instant};

use stepwright_feeder::{FeedState, FeedTerms, StreamFeeder};
use stepwright_path::{AxisPace, Lead, Planned, RouteStep};
use stepwright_plan::gcode::{GcodeJob, JobPlan};

use super::play::tell;
use super::port::{LOOK, Met, brakes, gone, kill, off, silent, spelt, tells, terms};
use crate::failure::Failure;
use crate::order::progress::Line;
use crate::order::target::PortArgs;
use crate::wish::{Obeyed, Wish};
use crate::{interrupt, say};

/// Between two reports of where the board is.
const REPORT: Duration = Duration::from_millis(20);
/// Between two reports for a terminal.
const SHOWN: Duration = Duration::from_millis(100);
/// What rests is told so for this long, in s.
const REST: f64 = 0.25;

/// Who watches a run.
pub trait JobWatch {
    /// How it is to go on.
    fn wish(&mut self) -> Wish;
    /// How far it is.
    fn tell(&mut self, place: &Place);
}

/// Where a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Seconds of the path, the time that it was held left out.
    pub seconds: f64,
    /// Steps of each axis since the start.
    pub steps: [i64; 3],
    /// What it obeys.
    pub wish: Wish,
}

/// What became of a job on a board.
pub struct Streamed {
    /// Where the axes are, in steps; `None` where that is not known.
    pub position: [Option<i64>; 3],
    /// Steps that came late, since the board was switched on.
    pub late: u64,
    /// Seconds of the path.
    pub seconds: f64,
    pub braked: bool,
    /// How often the line had to be called, and frames sent again.
    pub again: u64,
}

/// Ctrl-C, and a line on the terminal.
struct Terminal<'a> {
    plan: &'a JobPlan,
    line: Line,
    shown: Option<Instant>,
    told: bool,
}

impl JobWatch for Terminal<'_> {
    fn wish(&mut self) -> Wish {
        if interrupt::presses() >= 2 {
            return Wish::Kill;
        }
        if !interrupt::asked() {
            return Wish::Go;
        }
        if !std::mem::replace(&mut self.told, true) {
            self.line.note(interrupt::braking());
        }
        Wish::Brake
    }

    fn tell(&mut self, place: &Place) {
        if self.shown.is_none_or(|shown| shown.elapsed() > SHOWN) {
            self.shown = Some(Instant::now());
            tell(&mut self.line, place.seconds, self.plan.time, place.wish == Wish::Brake);
        }
    }
}

/// Streams a job that has been planned, and is not refused, for the one at the terminal.
pub fn stream(
    port: &PortArgs,
    job: Vec<u8>,
    axes: [AxisPace; 3],
    plan: &JobPlan,
) -> Result<Streamed, Failure> {
    let met = Met::at(port, "gcode")?;
    if met.places != [Some(0); 3] {
        let (name, at) = (&met.name, spelt(met.places));
        say::note(format_args!(
            "{name} is at {at}: the job takes that place for the machine's zero"
        ));
    }
    let mut terminal = Terminal { plan, line: Line::new(), shown: None, told: false };
    let streamed = feed(met, port.baud, job, axes, plan, &mut terminal);
    terminal.line.end();
    streamed
}

/// Streams a job that has been planned, and is not refused, to a board that was met.
pub fn feed(
    met: Met,
    baud: u32,
    job: Vec<u8>,
    axes: [AxisPace; 3],
    plan: &JobPlan,
    watch: &mut dyn JobWatch,
) -> Result<Streamed, Failure> {
    let Met { mut session, name, hz, stagger, .. } = met;
    let decels = [0, 1, 2].map(|n: usize| axes[n].accel / axes[n].step);
    let brakes = brakes(decels, hz).ok_or_else(|| {
        Failure::usage("an axis decelerates too slowly for a board that brakes by itself")
            .hint("--accel of 8 steps/s² and more")
    })?;
    let moves = plan.delays().into_iter().zip(0u8..).filter(|(delay, _)| delay.is_some());
    let moving = moves.map(|(_, axis)| 1 << axis).sum();
    let terms = FeedTerms { axes: moving, ..terms(brakes, hz, stagger, baud) };
    let wrong = |why: &dyn std::fmt::Display| Failure::usage(format!("the axes: {why}"));
    let job = GcodeJob::on(job, axes, &plan.terms).map_err(|why| wrong(&why))?;
    let mut run = JobRun {
        feeder: StreamFeeder::new(terms, 0),
        job: Lead::new(Job(job)),
        obeyed: Obeyed::default(),
        before: None,
        steps: [0; 3],
        known: 0.0,
    };
    let link = session.link();
    let begun = link.now();
    let mut buffer = [0; 256];
    let gone = |error| gone(&name, &error);
    let mut told = None::<Instant>;
    while !run.feeder.state().is_end() {
        let wish = watch.wish();
        if wish == Wish::Kill {
            return Err(kill(&mut session));
        }
        let micros = |now: Duration| now.saturating_sub(begun).as_micros() as u64;
        let bytes = run.turn(wish, micros(link.now()));
        if !bytes.is_empty() {
            link.write(&bytes).map_err(gone)?;
        }
        let count = link.read(&mut buffer, LOOK).map_err(gone)?;
        run.hear(buffer.get(..count).unwrap_or_default(), micros(link.now()));
        if told.is_none_or(|told| told.elapsed() >= REPORT) {
            told = Some(Instant::now());
            watch.tell(&run.place(micros(link.now())));
        }
    }
    watch.tell(&run.last());
    match run.feeder.state() {
        FeedState::Over => {}
        FeedState::Lost => return Err(silent(&name, "gcode")),
        state => return Err(off(&mut session, &name, state)),
    }
    let (position, late) = tells(&mut session)?;
    let (seconds, braked) = (run.job.ahead().0.time(), run.obeyed.wish == Wish::Brake);
    Ok(Streamed { position, late, seconds, braked, again: run.feeder.again() })
}

/// The job as it is planned ahead.
#[derive(Clone)]
struct Job(GcodeJob<std::vec::IntoIter<u8>>);

impl Planned for Job {
    /// What is wished, and from when on.
    type Order = (Wish, f64);

    fn step(&mut self) -> Option<RouteStep> {
        // What can't be read was said when it was planned.
        self.0.step().ok().flatten()
    }

    fn obey(&mut self, (wish, at): &(Wish, f64)) {
        match wish {
            Wish::Go => self.0.resume_at(*at),
            Wish::Hold => self.0.hold_at(*at),
            Wish::Brake | Wish::Kill => self.0.cancel_at(*at),
        }
    }

    fn stays(_: &(Wish, f64)) -> bool {
        false
    }
}

/// A job, and the feeder of its board.
struct JobRun {
    feeder: StreamFeeder,
    job: Lead<Job>,
    obeyed: Obeyed,
    /// What it did before a cut that the board has not taken yet.
    before: Option<Obeyed>,
    /// Where the board is.
    steps: [i64; 3],
    /// The board was told that no step comes before this time, in s.
    known: f64,
}

impl JobRun {
    /// Obeys a wish, and gives the bytes for the line. Times are µs since the start.
    fn turn(&mut self, wish: Wish, now: u64) -> Vec<u8> {
        let obeyed = self.obeyed;
        if wish != obeyed.wish
            && obeyed.wish < Wish::Brake
            && let Some(cut) = self.feeder.cut(now, wish != Wish::Go)
        {
            (self.before, self.obeyed) = (Some(obeyed), obeyed.then(wish, cut.time));
            self.job.cut(cut.steps, &[(wish, cut.time)]);
            self.known = cut.time;
        }
        while self.feeder.wants() {
            match self.job.plan() {
                Some(step) => self.feeder.step(step.axis, step.time, step.forward),
                None if self.job.ahead().0.is_held() => {
                    let rest = self.feeder.now(now).max(self.job.ahead().0.time()) + REST;
                    self.known = self.known.max(rest);
                    self.feeder.know(self.known);
                    break;
                }
                None => self.feeder.end(self.job.ahead().0.time()),
            }
        }
        self.feeder.bytes(now)
    }

    /// Takes bytes of the line.
    fn hear(&mut self, bytes: &[u8], now: u64) {
        self.feeder.hear(bytes, now);
        if self.feeder.was_late() {
            self.job.undo_cut();
            self.obeyed = self.before.take().unwrap_or(self.obeyed);
        } else if !self.feeder.is_cutting() {
            self.job.keep_cut();
            self.before = None;
        }
        self.pass(self.feeder.now(now));
    }

    /// The board has made all steps up to this time, in s.
    fn pass(&mut self, time: f64) {
        while let Some(step) = self.job.pass(time) {
            self.steps[step.axis] += if step.forward { 1 } else { -1 };
        }
    }

    /// Where the board is, by its clock.
    fn place(&self, now: u64) -> Place {
        self.place_at(self.feeder.now(now).max(0.0))
    }

    /// Where the run has ended.
    fn last(&mut self) -> Place {
        if self.feeder.state() != FeedState::Over {
            return self.place_at(self.feeder.time());
        }
        self.pass(f64::INFINITY);
        self.place_at(self.job.ahead().0.time())
    }

    fn place_at(&self, time: f64) -> Place {
        let (obeyed, steps) = (self.obeyed, self.steps);
        Place { seconds: obeyed.without_holds(time), steps, wish: obeyed.wish }
    }
}
