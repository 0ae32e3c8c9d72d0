//! A job for a page: planned within a bounded time, and run in real time on a virtual board of its
//! own.

use std::cell::Cell;
use std::thread;
use std::time::{Duration, Instant};

use stepwright_path::{AxisPace, Unplannable};
use stepwright_plan::gcode::JobPlan;
use stepwright_play::gcode::begin;
use stepwright_sim::Description;

use crate::board::edge_files::EdgePaths;
use crate::cycle::live::{PlayOrder, Played};
use crate::cycle::taken::{self, Taken};
use crate::failure::Failure;

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

/// Plans a job.
///
/// # Errors
/// The first error of the job, with its line and column; one that takes too long.
pub fn planned(name: &str, text: &str, axes: [AxisPace; 3]) -> Result<JobPlan, Failure> {
    let (begun, late, mut next) = (Instant::now(), Cell::new(false), BYTES);
    let bytes = text.bytes().take_while(|_| {
        next -= 1;
        if next == 0 {
            next = BYTES;
            late.set(late.get() || begun.elapsed() > WITHIN);
        }
        !late.get()
    });
    let plan = JobPlan::of(bytes, axes, &Description::uno().board, |_, _| {});
    // The end of what was read is not that of the job.
    if late.get() {
        return Err(long());
    }
    plan.map_err(|error| super::failure(name, &error))
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

/// Runs a job in real time. `tell` hears how far it is, in s, where the axes are, in nm, and
/// whether they brake, also at the end.
///
/// # Errors
/// An error of the job, or what the board refuses.
pub fn play(
    name: &str,
    text: &str,
    axes: [AxisPace; 3],
    order: &PlayOrder,
    tell: &mut dyn FnMut(f64, &[i64], bool),
) -> Result<Played, Failure> {
    let plan = planned(name, text, axes)?;
    if let Some(refused) = plan.refused {
        return Err(super::refusal(name, &refused));
    }
    let nothing =
        taken::Wanted { inverted: 0, edges: EdgePaths::default(), motions: false, events: false };
    let taken = |rate| Taken::begin(rate, 3, &nothing);
    begin(text.as_bytes().to_vec(), axes, &plan, taken, |mut job| {
        let hz = f64::from(job.rate.hz());
        let begun = Instant::now();
        let (mut braking, mut told) = (false, None::<Instant>);
        while job.is_running() {
            let order = order.end();
            if order == Some(Played::Killed) {
                break;
            }
            let brake = order.is_some() && !braking;
            if brake {
                braking = true;
                job.brake();
            }
            let limit = job.from + (begun.elapsed().as_secs_f64() * hz) as u64;
            let more = job.pass(limit, |_| ());
            if brake || told.is_none_or(|told| told.elapsed() >= REPORT) {
                told = Some(Instant::now());
                tell(job.passed() as f64 / hz, &nanometres(job.positions(), &axes), braking);
            }
            if !more && job.is_running() {
                thread::sleep(LOOK);
            }
        }
        tell(job.passed() as f64 / hz, &nanometres(job.positions(), &axes), braking);
        job.checked()?;
        Ok(match (job.is_running(), braking) {
            (true, _) => Played::Killed,
            (false, true) => Played::Stopped,
            (false, false) => Played::Done,
        })
    })
}

fn nanometres(steps: [i64; 3], axes: &[AxisPace; 3]) -> [i64; 3] {
    [0, 1, 2].map(|n| (steps[n] as f64 * axes[n].step * NM).round() as i64)
}
