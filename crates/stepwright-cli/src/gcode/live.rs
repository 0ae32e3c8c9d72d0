//! A job for a page: planned within a limited time, and run in real time, on a virtual board or on
//! a board that plays streams.

use std::cell::Cell;
use std::thread;
use std::time::{Duration, Instant};

use stepwright_path::{AxisPace, Unplannable};
use stepwright_plan::gcode::{JobPlan, JobTerms};
use stepwright_play::gcode::begin;
use stepwright_play::stream::{JobWatch, Obeyed, Place, PlayEnd, PlayOrder, PlayWish};
use stepwright_sim::Description;

use super::port;
use crate::cycle::taken::{self, Taken};
use crate::failure::Failure;
use crate::interrupt;
use crate::order::target::PortArgs;

/// The longest time to plan a job and make its drawing; beyond, it is refused.
pub const WITHIN: Duration = Duration::from_secs(10);

/// nm in a mm. Positions for a page are in nm, as whole numbers.
pub const NM: f64 = 1e6;

/// The number of bytes between two checks of the clock.
const BYTES: u32 = 256;

/// The time between two checks of the clock and the order.
const LOOK: Duration = Duration::from_millis(2);

/// The time between two reports.
const REPORT: Duration = Duration::from_millis(20);

/// A job of a page.
#[derive(Clone, Copy)]
pub struct PageJob<'a> {
    pub name: &'a str,
    pub text: &'a str,
    pub axes: [AxisPace; 3],
    /// The S of full power, if the job has a laser.
    pub laser: Option<f64>,
}

impl PageJob<'_> {
    /// Plans the job.
    ///
    /// # Errors
    /// The first error of the job, with line and column; planning takes too long.
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
        // Reading was cut off before the end of the job.
        if late.get() {
            return Err(long());
        }
        plan.map_err(|error| super::failure(self.name, &error))
    }

    /// Plans the job. A job that the board refuses is an error.
    fn admitted(&self) -> Result<JobPlan, Failure> {
        let plan = self.planned()?;
        match &plan.refused {
            Some(refused) => Err(super::refusal(self.name, refused)),
            None => Ok(plan),
        }
    }
}

/// The failure for a job that takes too long to draw.
pub fn long() -> Failure {
    Failure::new(format!("too long to draw here: more than {} s", WITHIN.as_secs()))
        .hint("`stepwright gcode FILE --plan` plans any job")
}

/// The failure for axes that can't be planned.
pub fn wrong(why: Unplannable) -> Failure {
    Failure::new(format!("the axes of the machine file: {why}"))
}

/// Runs a job in real time. Calls `tell` with the time in s, without the time on hold, the axes'
/// positions in nm, and the wish that the job obeys; also at the end.
///
/// # Errors
/// An error of the job; a refusal of the board.
pub fn play(
    file: &PageJob,
    order: &PlayOrder,
    tell: &mut dyn FnMut(f64, &[i64], PlayWish),
) -> Result<PlayEnd, Failure> {
    let (plan, axes) = (file.admitted()?, file.axes);
    let nothing = taken::Wanted::default();
    let taken = |rate| Taken::begin(rate, 3, &nothing);
    begin(file.text.as_bytes().to_vec(), axes, &plan, taken, |mut job| {
        let hz = f64::from(job.rate.hz());
        let begun = Instant::now();
        let (mut obeyed, mut told) = (Obeyed::default(), None::<Instant>);
        while job.is_running() {
            let wish = order.wish();
            if wish == PlayWish::Kill {
                break;
            }
            let changes = wish != obeyed.wish && obeyed.wish < PlayWish::Brake;
            if changes {
                match wish {
                    PlayWish::Hold => job.hold(),
                    PlayWish::Go => job.resume(),
                    PlayWish::Brake | PlayWish::Kill => job.brake(),
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
            (true, _) => PlayEnd::Killed,
            (false, PlayWish::Brake) => PlayEnd::Stopped,
            (false, _) => PlayEnd::Done,
        })
    })
}

/// Runs a job on the stream board at this port. Calls `tell` like [`play`].
///
/// # Errors
/// An error of the job; no such board at the port; the board has left the path.
pub fn play_on(
    at: &PortArgs,
    file: &PageJob,
    order: &PlayOrder,
    tell: &mut dyn FnMut(f64, &[i64], PlayWish),
) -> Result<PlayEnd, Failure> {
    let (plan, axes) = (file.planned()?, file.axes);
    let mut board = port::meet(at, "serve")?;
    let from = board.places;
    let mut watch = Page { order, axes, tell, steps: [0; 3], killed: false };
    let played = board.play(file.text.as_bytes().to_vec(), axes, &plan, &mut watch);
    let steps = watch.steps;
    let elsewhere = |to: [Option<i64>; 3]| {
        (0..3).any(|n| matches!((from[n], to[n]), (Some(a), Some(b)) if b - a != steps[n]))
    };
    match played {
        Ok(streamed) if elsewhere(streamed.position) => {
            Err(Failure::new(format!("{} counts another place than the path's end", board.name)))
        }
        Ok(streamed) if streamed.braked => Ok(PlayEnd::Stopped),
        Ok(_) => Ok(PlayEnd::Done),
        Err(_) if watch.killed => Ok(PlayEnd::Killed),
        Err(why) => Err(why.into()),
    }
}

/// A page that follows a run on a board.
struct Page<'a> {
    order: &'a PlayOrder,
    axes: [AxisPace; 3],
    tell: &'a mut dyn FnMut(f64, &[i64], PlayWish),
    /// The last reported position.
    steps: [i64; 3],
    killed: bool,
}

impl JobWatch for Page<'_> {
    fn wish(&mut self) -> PlayWish {
        // If the server ends, the board brakes, and by a second Ctrl-C it stops.
        let end = match (interrupt::presses(), interrupt::asked()) {
            (2.., _) => PlayWish::Kill,
            (_, true) => PlayWish::Brake,
            _ => PlayWish::Go,
        };
        let wish = self.order.wish().max(end);
        self.killed |= wish == PlayWish::Kill;
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
