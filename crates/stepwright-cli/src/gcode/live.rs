//! A job for a page: planned within a bounded time, and run in real time, on a virtual board of its
//! own or on one that plays streams.

use std::cell::Cell;
use std::thread;
use std::time::{Duration, Instant};

use stepwright_path::{AxisPace, Unplannable};
use stepwright_plan::gcode::{JobPlan, JobTerms};
use stepwright_play::gcode::begin;
use stepwright_sim::Description;

use super::feed::{self, JobWatch, Place};
use super::port::Met;
use crate::cycle::taken::{self, Taken};
use crate::failure::Failure;
use crate::interrupt;
use crate::order::target::PortArgs;
use crate::wish::{Obeyed, PlayOrder, Played, Wish};

/// A job is planned, and a drawing made, within this long, or not at all.
pub const WITHIN: Duration = Duration::from_secs(10);

/// nm in a mm. What a page is told counts in them: whole numbers say where a run is.
pub const NM: f64 = 1e6;

/// Bytes from one look at the clock to the next.
const BYTES: u32 = 256;

/// Between two looks at the clock: an order is heard so soon.
const LOOK: Duration = Duration::from_millis(2);

/// Between two reports.
const REPORT: Duration = Duration::from_millis(20);

/// A job that a page has.
#[derive(Clone, Copy)]
pub struct PageJob<'a> {
    pub name: &'a str,
    pub text: &'a str,
    pub axes: [AxisPace; 3],
    /// S of full power, of one with a laser.
    pub laser: Option<f64>,
}

impl PageJob<'_> {
    /// Plans it.
    ///
    /// # Errors
    /// Its first error, with line and column; it takes too long.
    pub fn planned(&self) -> Result<JobPlan, Failure> {
        let (begun, late, mut next) = (Instant::now(), Cell::new(false), BYTES);
        let bytes = self.text.bytes().take_while(|_| {
            next -= 1;
            if next == 0 {
                next = BYTES;
                late.set(late.get() || begun.elapsed() > WITHIN);
            }
            !late.get()
        });
        let terms = JobTerms { laser: self.laser, ..JobTerms::default() };
        let plan = JobPlan::on(bytes, self.axes, &terms, &Description::uno().board, |_, _| {});
        // The end of what was read is not that of the job.
        if late.get() {
            return Err(long());
        }
        plan.map_err(|error| super::failure(self.name, &error))
    }

    /// Plans it, and it is not refused.
    fn admitted(&self) -> Result<JobPlan, Failure> {
        let plan = self.planned()?;
        match &plan.refused {
            Some(refused) => Err(super::refusal(self.name, refused)),
            None => Ok(plan),
        }
    }
}

/// It takes too long.
pub fn long() -> Failure {
    Failure::new(format!("too long to draw here: more than {} s", WITHIN.as_secs()))
        .hint("`stepwright gcode FILE --plan` plans any job")
}

/// Axes that can't be planned for.
pub fn wrong(why: Unplannable) -> Failure {
    Failure::new(format!("the axes of the machine file: {why}"))
}

/// Runs a job in real time. `tell` hears how far it is, in s without the time that it was held, where the
/// axes are, in nm, and what it obeys, also at the end.
///
/// # Errors
/// An error of the job, or what the board refuses.
pub fn play(
    file: &PageJob,
    order: &PlayOrder,
    tell: &mut dyn FnMut(f64, &[i64], Wish),
) -> Result<Played, Failure> {
    let (plan, axes) = (file.admitted()?, file.axes);
    let nothing = taken::Wanted::default();
    let taken = |rate| Taken::begin(rate, 3, &nothing);
    begin(file.text.as_bytes().to_vec(), axes, &plan, taken, |mut job| {
        let hz = f64::from(job.rate.hz());
        let begun = Instant::now();
        let (mut obeyed, mut told) = (Obeyed::default(), None::<Instant>);
        while job.is_running() {
            let wish = order.wish();
            if wish == Wish::Kill {
                break;
            }
            let changes = wish != obeyed.wish && obeyed.wish < Wish::Brake;
            if changes {
                match wish {
                    Wish::Hold => job.hold(),
                    Wish::Go => job.resume(),
                    Wish::Brake | Wish::Kill => job.brake(),
                }
                obeyed = obeyed.then(wish, job.passed() as f64 / hz);
            }
            let limit = job.from + (begun.elapsed().as_secs_f64() * hz) as u64;
            let more = job.pass(limit, |_, _| ());
            if changes || told.is_none_or(|told| told.elapsed() >= REPORT) {
                told = Some(Instant::now());
                let seconds = obeyed.without_holds(job.passed() as f64 / hz);
                tell(seconds, &nanometres(job.positions(), &axes), obeyed.wish);
            }
            if !more && job.is_running() {
                thread::sleep(LOOK);
            }
        }
        let seconds = obeyed.without_holds(job.passed() as f64 / hz);
        tell(seconds, &nanometres(job.positions(), &axes), obeyed.wish);
        job.checked()?;
        Ok(match (job.is_running(), obeyed.wish) {
            (true, _) => Played::Killed,
            (false, Wish::Brake) => Played::Stopped,
            (false, _) => Played::Done,
        })
    })
}

/// Runs a job on the board at this port, which plays streams: `tell` hears as above.
///
/// # Errors
/// An error of the job; no such board is there, or it has left the path.
pub fn play_on(
    port: &PortArgs,
    file: &PageJob,
    order: &PlayOrder,
    tell: &mut dyn FnMut(f64, &[i64], Wish),
) -> Result<Played, Failure> {
    let (plan, axes) = (file.admitted()?, file.axes);
    let met = Met::at(port, "serve")?;
    let (from, board) = (met.places, met.name.clone());
    let mut watch = Page { order, axes, tell, steps: [0; 3], killed: false };
    let fed = feed::feed(met, port.baud, file.text.as_bytes().to_vec(), axes, &plan, &mut watch);
    let steps = watch.steps;
    let elsewhere = |to: [Option<i64>; 3]| {
        (0..3).any(|n| matches!((from[n], to[n]), (Some(a), Some(b)) if b - a != steps[n]))
    };
    match fed {
        Ok(streamed) if elsewhere(streamed.position) => {
            Err(Failure::new(format!("{board} counts another place than the path's end")))
        }
        Ok(streamed) if streamed.braked => Ok(Played::Stopped),
        Ok(_) => Ok(Played::Done),
        Err(_) if watch.killed => Ok(Played::Killed),
        Err(why) => Err(why),
    }
}

/// A page that follows a run on a board.
struct Page<'a> {
    order: &'a PlayOrder,
    axes: [AxisPace; 3],
    tell: &'a mut dyn FnMut(f64, &[i64], Wish),
    /// Where it was last.
    steps: [i64; 3],
    killed: bool,
}

impl JobWatch for Page<'_> {
    fn wish(&mut self) -> Wish {
        // The server ends: its board brakes.
        let end = if interrupt::asked() { Wish::Brake } else { Wish::Go };
        let wish = self.order.wish().max(end);
        self.killed |= wish == Wish::Kill;
        wish
    }

    fn tell(&mut self, place: &Place) {
        self.steps = place.steps;
        (self.tell)(place.seconds, &nanometres(place.steps, &self.axes), place.wish);
    }
}

fn nanometres(steps: [i64; 3], axes: &[AxisPace; 3]) -> [i64; 3] {
    [0, 1, 2].map(|n| (steps[n] as f64 * axes[n].step * NM).round() as i64)
}
