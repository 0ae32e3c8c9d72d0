//! Streams a job to a board: the steps are planned here and sent as they are needed.
//!
//! ```text
//!   wish ─► cut: what was sent ahead is taken back, and the plan goes on from there
//!   job ─► steps ─► feeder ─► line ─► board
//!            └─ where the board is by now ─► told
//! ```

use std::iter;
use std::time::{Duration, Instant};

use stepwright_feeder::{FeedState, FeedTerms, StreamFeeder};
use stepwright_path::{AxisPace, Lead, Planned, RouteStep};
use stepwright_plan::gcode::{GcodeJob, JobPlan, PowerChange};

use super::board::StreamedBoard;
use super::wish::{Obeyed, PlayOrder, PlayWish};
use crate::PlayError;

/// The time between two reads of the line.
pub const LOOK: Duration = Duration::from_millis(1);

/// The answers to frames under way have come if the board is quiet for this long.
const UNDER_WAY: Duration = Duration::from_millis(100);
/// The time between two reports of the board's position.
pub(crate) const REPORT: Duration = Duration::from_millis(20);
/// The board is told of a rest this far ahead, in s.
const REST: f64 = 0.25;

/// An observer that watches and controls a run.
pub trait JobWatch {
    /// How the run shall continue.
    fn wish(&mut self) -> PlayWish;
    /// Reports the progress.
    fn tell(&mut self, place: &Place);
}

impl JobWatch for &PlayOrder {
    fn wish(&mut self) -> PlayWish {
        PlayOrder::wish(self)
    }

    fn tell(&mut self, _: &Place) {}
}

/// The progress of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Seconds of the path, without the time on hold.
    pub seconds: f64,
    /// Steps of each axis since the start.
    pub steps: [i64; 3],
    /// The wish that it obeys.
    pub wish: PlayWish,
}

/// The result of a job on a board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Streamed {
    /// The axes' positions in steps; `None` if unknown.
    pub position: [Option<i64>; 3],
    /// Late steps since the board was switched on.
    pub late: u64,
    /// Seconds of the path.
    pub seconds: f64,
    /// Whether a wish braked it before its end.
    pub braked: bool,
    /// How often the line had to be polled, and frames sent again.
    pub again: u64,
}

impl StreamedBoard {
    /// Streams a job that has been planned and admitted: the axes stand at its beginning.
    ///
    /// # Errors
    /// The board has no output for the job's laser; an axis decelerates too slowly for a board that
    /// brakes by itself; the board is lost, or has left the path; a kill.
    pub fn play(
        &mut self,
        job: Vec<u8>,
        axes: [AxisPace; 3],
        plan: &JobPlan,
        watch: &mut dyn JobWatch,
    ) -> Result<Streamed, PlayError> {
        self.admits(plan)?;
        let decels = [0, 1, 2].map(|n: usize| axes[n].accel / axes[n].step);
        let terms = self.terms(decels).ok_or_else(|| {
            PlayError::new("an axis decelerates too slowly for a board that brakes by itself")
                .hint("an acceleration of 8 steps/s² and more")
        })?;
        let moves = plan.delays().into_iter().zip(0u8..).filter(|(delay, _)| delay.is_some());
        let moving = moves.map(|(_, axis)| 1 << axis).sum();
        let terms = FeedTerms { axes: moving, laser: plan.laser.is_some(), ..terms };
        let job = GcodeJob::on(job, axes, &plan.terms)
            .map_err(|why| PlayError::new(format!("the axes: {why}")))?;
        let mut run = JobRun::new(terms, job);
        let begun = self.session.now();
        let mut buffer = [0; 256];
        let mut told = None::<Instant>;
        while !run.feeder.state().is_end() {
            let wish = watch.wish();
            if wish == PlayWish::Kill {
                return Err(self.kill());
            }
            if run.is_called_off(wish) {
                // Frames may still be under way.
                self.hush(UNDER_WAY);
                break;
            }
            let micros = |now: Duration| now.saturating_sub(begun).as_micros() as u64;
            let link = self.session.link();
            let bytes = run.turn(wish, micros(link.now()));
            let written = if bytes.is_empty() { Ok(()) } else { link.write(&bytes) };
            let read = written.and_then(|()| link.read(&mut buffer, LOOK));
            let now = micros(link.now());
            let count = read.map_err(|error| self.gone(&error))?;
            run.hear(buffer.get(..count).unwrap_or_default(), now);
            if told.is_none_or(|told| told.elapsed() >= REPORT) {
                told = Some(Instant::now());
                watch.tell(&run.place(now));
            }
        }
        watch.tell(&run.last());
        let seconds = match run.feeder.state() {
            FeedState::Over => run.job.ahead().job.time(),
            // It was called off.
            FeedState::Filling => 0.0,
            FeedState::Lost => return Err(self.silent()),
            state => return Err(self.off(state)),
        };
        let (position, late) = self.tells()?;
        let braked = run.obeyed.wish == PlayWish::Brake;
        Ok(Streamed { position, late, seconds, braked, again: run.feeder.again() })
    }
}

/// The job, which is planned ahead of the board.
#[derive(Clone)]
struct Job {
    job: GcodeJob<std::vec::IntoIter<u8>>,
    /// The changes of the laser's power between the last two steps, or up to a rest after the last
    /// step.
    lit: Vec<PowerChange>,
}

/// Power changes are read up to this far into a rest, in s: the laser goes off at its start.
const INTO: f64 = 1e-3;

impl Planned for Job {
    /// A wish, and the time from which it counts.
    type Order = (PlayWish, f64);

    fn step(&mut self) -> Option<RouteStep> {
        // Errors were reported when the job was planned.
        let step = self.job.step().ok().flatten();
        let until = step.map_or(self.job.time() + INTO, |step| step.time);
        self.lit.clear();
        self.lit.extend(iter::from_fn(|| self.job.power(until)));
        step
    }

    fn obey(&mut self, (wish, at): &(PlayWish, f64)) {
        match wish {
            PlayWish::Go => self.job.resume_at(*at),
            PlayWish::Hold => self.job.hold_at(*at),
            PlayWish::Brake | PlayWish::Kill => self.job.cancel_at(*at),
        }
    }

    fn stays(_: &(PlayWish, f64)) -> bool {
        false
    }
}

/// A power as a byte for the board. Only off is 0.
fn byte(power: f64) -> u8 {
    let byte = (power * 255.0).round() as u8;
    byte.max(u8::from(power > 0.0))
}

/// A job, and the feeder for its board.
struct JobRun {
    feeder: StreamFeeder,
    job: Lead<Job>,
    obeyed: Obeyed,
    /// The feeder has the laser's power up to this time, in s.
    lit: f64,
    /// `obeyed` and `lit` before a cut that the board has not accepted yet.
    before: Option<(Obeyed, f64)>,
    /// The board's position.
    steps: [i64; 3],
    /// The board was told that no step comes before this time, in s.
    known: f64,
}

impl JobRun {
    /// A run that begins now, at 0 µs.
    fn new(terms: FeedTerms, job: GcodeJob<std::vec::IntoIter<u8>>) -> JobRun {
        JobRun {
            feeder: StreamFeeder::new(terms, 0),
            job: Lead::new(Job { job, lit: Vec::new() }),
            obeyed: Obeyed::default(),
            lit: 0.0,
            before: None,
            steps: [0; 3],
            known: 0.0,
        }
    }

    /// Obeys a wish before the axes have started: a hold keeps the run from beginning. Returns whether the
    /// run is to end.
    fn is_called_off(&mut self, wish: PlayWish) -> bool {
        if self.feeder.state() != FeedState::Filling {
            return false;
        }
        self.feeder.wait(wish != PlayWish::Go);
        self.obeyed = self.obeyed.then(wish, 0.0);
        wish >= PlayWish::Brake
    }

    /// Obeys a wish, and returns the bytes to send. Times are µs since the start.
    fn turn(&mut self, wish: PlayWish, now: u64) -> Vec<u8> {
        let obeyed = self.obeyed;
        if wish != obeyed.wish
            && obeyed.wish < PlayWish::Brake
            && let Some(cut) = self.feeder.cut(now, wish != PlayWish::Go)
        {
            (self.before, self.obeyed) = (Some((obeyed, self.lit)), obeyed.then(wish, cut.time));
            self.job.cut(cut.steps, &[(wish, cut.time)]);
            (self.known, self.lit) = (cut.time, self.lit.min(cut.time));
        }
        while self.feeder.wants() {
            let step = self.job.plan();
            let Job { job, lit } = self.job.ahead();
            for change in lit.iter().filter(|change| change.time >= self.lit) {
                self.feeder.power(change.time, byte(change.power));
            }
            let time = job.time();
            match step {
                Some(step) => {
                    self.lit = self.lit.max(step.time);
                    self.feeder.step(step.axis, step.time, step.forward);
                }
                None if job.is_held() => {
                    self.lit = self.lit.max(time);
                    let rest = self.feeder.now(now).max(time) + REST;
                    self.known = self.known.max(rest);
                    self.feeder.know(self.known);
                    break;
                }
                None => self.feeder.end(time),
            }
        }
        self.feeder.bytes(now)
    }

    /// Takes bytes from the line.
    fn hear(&mut self, bytes: &[u8], now: u64) {
        self.feeder.hear(bytes, now);
        if self.feeder.was_late() {
            self.job.undo_cut();
            (self.obeyed, self.lit) = self.before.take().unwrap_or((self.obeyed, self.lit));
        } else if !self.feeder.is_cutting() {
            self.job.keep_cut();
            self.before = None;
        }
        self.pass(self.feeder.now(now));
    }

    /// Counts the steps that the board has made up to this time, in s.
    fn pass(&mut self, time: f64) {
        while let Some(step) = self.job.pass(time) {
            self.steps[step.axis] += if step.forward { 1 } else { -1 };
        }
    }

    /// The board's progress at its present time.
    fn place(&self, now: u64) -> Place {
        // The board's clock goes on behind the end.
        let end = self.job.ahead().job.time();
        self.place_at(self.feeder.now(now).min(end).max(0.0))
    }

    /// The progress at the end of the run.
    fn last(&mut self) -> Place {
        if self.feeder.state() != FeedState::Over {
            return self.place_at(self.feeder.time());
        }
        self.pass(f64::INFINITY);
        self.place_at(self.job.ahead().job.time())
    }

    fn place_at(&self, time: f64) -> Place {
        let (obeyed, steps) = (self.obeyed, self.steps);
        Place { seconds: obeyed.without_holds(time), steps, wish: obeyed.wish }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stepwright_plan::gcode::JobTerms;
    use stepwright_sim::{Description, Edge, Queues, Recorder, StreamBoard};
    use stepwright_stream::brake::BrakeLaw;

    #[derive(Default)]
    struct Watch {
        steps: Vec<u64>,
        powers: Vec<(u64, u8)>,
    }

    impl Recorder for Watch {
        fn edge(&mut self, edge: Edge) {
            if edge.is_step() {
                self.steps.push(edge.time);
            }
        }
        fn laser(&mut self, time: u64, power: u8) {
            self.powers.push((time, power));
        }
    }

    /// Holds and resumes a job several times, with M3 and with M4. The laser goes off at each rest,
    /// and on again with the first step after it.
    #[test]
    fn a_hold_is_dark() {
        let axis =
            AxisPace { step: 0.0125, speed: 200.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
        for mode in ["M3", "M4"] {
            let text = format!("{mode} S1000\nG1 X60 F1200\n").into_bytes();
            let terms = JobTerms { laser: Some(1_000.0), ..JobTerms::default() };
            let job = GcodeJob::on(text, [axis; 3], &terms).ok().unwrap();
            let brakes = [BrakeLaw::of(80_000_000, 16_000_000).unwrap(); 3];
            let fed = FeedTerms { axes: 1, laser: true, ..FeedTerms::avr(brakes) };
            let mut run = JobRun::new(fed, job);
            let mut queues = Queues::default();
            let mut board: StreamBoard<Watch> =
                StreamBoard::new(&mut queues, Description::uno(), Watch::default());
            let mut millis = 0;
            while !run.feeder.state().is_end() && millis < 20_000 {
                millis += 1;
                board.run_until(millis * 16_000);
                let said = board.take_answers();
                run.hear(&said, millis * 1_000);
                let wish = if millis % 1_000 > 600 { PlayWish::Hold } else { PlayWish::Go };
                let bytes = run.turn(wish, millis * 1_000);
                board.receive(&bytes);
            }
            assert_eq!(run.feeder.state(), FeedState::Over);
            let watch = board.recorder();
            assert_eq!(watch.steps.len(), 4_800);
            let power = |time: u64| {
                let n = watch.powers.partition_point(|power| power.0 <= time);
                n.checked_sub(1).map_or(0, |n| watch.powers[n].1)
            };
            let mut rests = 0;
            for pair in watch.steps.windows(2) {
                let [before, behind] = [pair[0], pair[1]];
                if behind - before > 16_000 * 100 {
                    rests += 1;
                    assert_eq!(power(before + 16_000 * 40), 0, "{mode}: {before}");
                    assert_eq!(power(behind - 16_000 * 20), 0, "{mode}: {behind}");
                    // Unless the job has ended by then.
                    let moves = watch.steps.last() > Some(&(behind + 16_000 * 90));
                    assert!(!moves || power(behind + 16_000 * 60) > 240, "{mode}: {behind}");
                    assert!(power(before - 16_000 * 60) > 240, "{mode}: {before}");
                }
            }
            assert!(rests >= 2, "{rests}");
            assert_eq!(power(u64::MAX), 0);
        }
    }

    /// A job and a board, looked at each ms, under these wishes from these ms on. Returns the run, the
    /// number of steps, and the ms of the first.
    fn wished(wishes: &[(u64, PlayWish)]) -> (JobRun, usize, Option<u64>) {
        let axis =
            AxisPace { step: 0.0125, speed: 200.0, accel: 1_000.0, jump: 5.0, jerk: f64::INFINITY };
        let job = b"G1 X5 F1200\n".to_vec();
        let job = GcodeJob::on(job, [axis; 3], &JobTerms::default()).ok().unwrap();
        let brakes = [BrakeLaw::of(80_000_000, 16_000_000).unwrap(); 3];
        let mut run = JobRun::new(FeedTerms { axes: 1, ..FeedTerms::avr(brakes) }, job);
        let mut queues = Queues::default();
        let mut board: StreamBoard<Watch> =
            StreamBoard::new(&mut queues, Description::uno(), Watch::default());
        for millis in 1..10_000 {
            board.run_until(millis * 16_000);
            let said = board.take_answers();
            run.hear(&said, millis * 1_000);
            let wish = wishes.iter().rev().find(|(from, _)| *from <= millis).unwrap().1;
            if run.is_called_off(wish) || run.feeder.state().is_end() {
                break;
            }
            let bytes = run.turn(wish, millis * 1_000);
            board.receive(&bytes);
        }
        board.run_until(12_000 * 16_000);
        let steps = &board.recorder().steps;
        (run, steps.len(), steps.first().map(|time| time / 16_000))
    }

    #[test]
    fn what_has_not_begun_does_not_begin() {
        let (_, steps, begun) = wished(&[(0, PlayWish::Go)]);
        let begun = begun.unwrap();
        assert_eq!(steps, 400);
        for at in [0, 1, begun / 4, begun / 2] {
            let (run, steps, _) = wished(&[(0, PlayWish::Go), (at, PlayWish::Brake)]);
            assert_eq!((run.feeder.state(), steps), (FeedState::Filling, 0), "{at} of {begun}");
            assert_eq!(run.obeyed.wish, PlayWish::Brake);
            // For longer than a silent board is waited for.
            let (run, steps, first) =
                wished(&[(0, PlayWish::Go), (at, PlayWish::Hold), (at + 5_000, PlayWish::Go)]);
            assert_eq!((run.feeder.state(), steps), (FeedState::Over, 400), "{at} of {begun}");
            assert!(first > Some(at + 5_000), "{first:?}");
        }
    }
}
