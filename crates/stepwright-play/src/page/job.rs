//! A job for a page: planned within a limited time, and run in real time, on a virtual board or on
//! a board that plays streams.

use std::cell::Cell;
use std::time::{Duration, Instant};

use stepwright_path::AxisPace;
use stepwright_plan::gcode::{JobPlan, JobTerms};
use stepwright_sim::Description;

use super::PageListener;
use crate::PlayError;
use crate::gcode::begin;
use crate::stream::{JobWatch, Place, PlayEnd, PlayOrder, PlayWish, StreamedBoard};

/// The longest time to plan a job and make its drawing; beyond, it is refused.
pub(super) const WITHIN: Duration = Duration::from_secs(10);

/// nm in a mm. Positions for a page are in nm, as whole numbers.
pub(super) const NM: f64 = 1e6;

/// The number of bytes between two checks of the clock.
const BYTES: u32 = 256;

/// A job of a page.
#[derive(Clone, Copy)]
pub struct PageJob<'a> {
    /// Its name in messages.
    pub name: &'a str,
    /// Its text.
    pub text: &'a str,
    /// The limits of X, Y and Z.
    pub axes: [AxisPace; 3],
    /// The S of full power, if the job has a laser.
    pub laser: Option<f64>,
}

impl PageJob<'_> {
    /// Plans the job.
    ///
    /// # Errors
    /// The first error of the job, with line and column; planning takes too long.
    pub fn planned(&self) -> Result<JobPlan, PlayError> {
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
        plan.map_err(|error| PlayError::job(self.name, &error))
    }

    /// Runs the job on a virtual board in real time. Calls `tell` with the time in s, without the time
    /// on hold, the axes' positions in nm, and the wish that the job obeys; also at the end.
    ///
    /// # Errors
    /// An error of the job; a refusal of the board.
    pub fn play(&self, order: &PlayOrder, tell: PageListener) -> Result<PlayEnd, PlayError> {
        let plan = self.planned()?;
        if let Some(refused) = &plan.refused {
            return Err(PlayError::refused_job(self.name, refused));
        }
        let (job, axes) = (self.text.as_bytes().to_vec(), self.axes);
        let mut watch = Watch { order, axes, tell, steps: [0; 3] };
        begin(job, axes, &plan, |_| Ok(()), |mut job| job.play(false, &mut watch, |_, _| ()))
    }

    /// Runs the job on a stream board. Calls `tell` like [`play`](PageJob::play).
    ///
    /// # Errors
    /// An error of the job; the board has left the path.
    pub fn play_on(
        &self,
        board: &mut StreamedBoard,
        order: &PlayOrder,
        tell: PageListener,
    ) -> Result<PlayEnd, PlayError> {
        let (plan, job, axes) = (self.planned()?, self.text.as_bytes().to_vec(), self.axes);
        let from = board.places;
        let mut watch = Watch { order, axes, tell, steps: [0; 3] };
        let played = board.play(job, axes, &plan, &mut watch);
        let steps = watch.steps;
        let elsewhere = |to: [Option<i64>; 3]| {
            (0..3).any(|n| matches!((from[n], to[n]), (Some(a), Some(b)) if b - a != steps[n]))
        };
        match played {
            Ok(streamed) if elsewhere(streamed.position) => {
                let name = &board.name;
                Err(PlayError::new(format!("{name} counts another place than the path's end")))
            }
            Ok(streamed) if streamed.braked => Ok(PlayEnd::Stopped),
            Ok(_) => Ok(PlayEnd::Done),
            Err(_) if order.wish() == PlayWish::Kill => Ok(PlayEnd::Killed),
            Err(why) => Err(why),
        }
    }
}

/// The error for a job that takes too long to draw.
pub(super) fn long() -> PlayError {
    PlayError::new(format!("too long to draw here: more than {} s", WITHIN.as_secs()))
        .hint("`stepwright gcode FILE --plan` plans any job")
}

/// A page that follows a run.
struct Watch<'a> {
    order: &'a PlayOrder,
    axes: [AxisPace; 3],
    tell: PageListener<'a>,
    /// The last reported position.
    steps: [i64; 3],
}

impl JobWatch for Watch<'_> {
    fn wish(&mut self) -> PlayWish {
        self.order.wish()
    }

    fn tell(&mut self, place: &Place) {
        self.steps = place.steps;
        let nanometres =
            [0, 1, 2].map(|n| (place.steps[n] as f64 * self.axes[n].step * NM).round() as i64);
        (self.tell)(place.seconds, &nanometres, place.wish);
    }
}
