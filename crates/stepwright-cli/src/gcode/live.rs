//! A job for a page: planned within a limited time, and run in real time, on a virtual board or on
//! a board that plays streams.

use std::cell::Cell;
use std::time::{Duration, Instant};

use stepwright_path::{AxisPace, Unplannable};
use stepwright_plan::gcode::{JobPlan, JobTerms};
use stepwright_play::gcode::begin;
use stepwright_play::stream::{JobWatch, Place, PlayEnd, PlayOrder, PlayWish};
use stepwright_sim::Description;

use super::port;
use crate::failure::Failure;
use crate::interrupt;
use crate::order::target::PortArgs;

/// The longest time to plan a job and make its drawing; beyond, it is refused.
pub const WITHIN: Duration = Duration::from_secs(10);

/// nm in a mm. Positions for a page are in nm, as whole numbers.
pub const NM: f64 = 1e6;

/// The number of bytes between two checks of the clock.
const BYTES: u32 = 256;

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
    let mut page = Page::new(order, axes, tell);
    begin(
        file.text.as_bytes().to_vec(),
        axes,
        &plan,
        |_| Ok(()),
        |mut job| Ok(job.play(false, &mut page, |_, _| ())?),
    )
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
    let mut page = Page::new(order, axes, tell);
    let played = board.play(file.text.as_bytes().to_vec(), axes, &plan, &mut page);
    let steps = page.steps;
    let elsewhere = |to: [Option<i64>; 3]| {
        (0..3).any(|n| matches!((from[n], to[n]), (Some(a), Some(b)) if b - a != steps[n]))
    };
    match played {
        Ok(streamed) if elsewhere(streamed.position) => {
            Err(Failure::new(format!("{} counts another place than the path's end", board.name)))
        }
        Ok(streamed) if streamed.braked => Ok(PlayEnd::Stopped),
        Ok(_) => Ok(PlayEnd::Done),
        Err(_) if page.killed => Ok(PlayEnd::Killed),
        Err(why) => Err(why.into()),
    }
}

/// A page that follows a run.
struct Page<'a> {
    order: &'a PlayOrder,
    axes: [AxisPace; 3],
    tell: &'a mut dyn FnMut(f64, &[i64], PlayWish),
    /// The last reported position.
    steps: [i64; 3],
    killed: bool,
}

impl<'a> Page<'a> {
    fn new(
        order: &'a PlayOrder,
        axes: [AxisPace; 3],
        tell: &'a mut dyn FnMut(f64, &[i64], PlayWish),
    ) -> Page<'a> {
        Page { order, axes, tell, steps: [0; 3], killed: false }
    }
}

impl JobWatch for Page<'_> {
    fn wish(&mut self) -> PlayWish {
        // If the server ends, the run brakes, and by a second Ctrl-C it stops.
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
        let nanometres =
            [0, 1, 2].map(|n| (place.steps[n] as f64 * self.axes[n].step * NM).round() as i64);
        (self.tell)(place.seconds, &nanometres, place.wish);
    }
}
