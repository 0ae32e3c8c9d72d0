//! G-code jobs on a virtual board and on a real one, and planned paths of waypoints.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use pyo3::exceptions::{PyConnectionError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use stepwright_host::Session;
use stepwright_host::link::bench::BenchRecorder;
use stepwright_host::link::serial::{LeaseWait, SerialLink, Share};
use stepwright_keeper::scope::ScopeSource;
use stepwright_path::{ArcFit, AxisPace, Route};
use stepwright_plan::gcode::JobPlan;
use stepwright_play::edges::EdgeStore;
use stepwright_play::stream::{JobWatch, Place, PlayEnd, PlayWish, StreamedBoard};
use stepwright_play::{PlayError, gcode};
use stepwright_sim::Pin;

use crate::run::{Run, Silent, Way, playing};

/// The limits of an axis: step in mm, speed in mm/s, acceleration in mm/s², jump in speed in mm/s, jerk in
/// mm/s³.
pub type Pace = (f64, f64, f64, f64, f64);

/// The limits as a struct.
pub fn pace((step, speed, accel, jump, jerk): Pace) -> AxisPace {
    AxisPace { step, speed, accel, jump, jerk }
}

const NAMES: [&str; 3] = ["x", "y", "z"];

/// STEP and DIR of a motor.
const PINS: [(Pin, Option<bool>); 2] = [(Pin::Step, Some(false)), (Pin::Direction, None)];

/// Brakes a run when a program asks for it.
struct Asked<'a>(&'a AtomicBool);

impl JobWatch for Asked<'_> {
    fn wish(&mut self) -> PlayWish {
        if self.0.load(Ordering::Relaxed) { PlayWish::Brake } else { PlayWish::Go }
    }

    fn tell(&mut self, _: &Place) {}
}

/// Runs a planned job that is not refused, until it ends, or is braked after `asked`.
pub fn play(
    bytes: &[u8],
    axes: [AxisPace; 3],
    plan: &JobPlan,
    fast: bool,
    asked: &AtomicBool,
) -> PyResult<Run> {
    let mut edges = None;
    let pins = (0..3).flat_map(|axis| PINS.map(|(pin, level)| (axis, pin, level)));
    let recorder = |rate: stepwright::Rate| {
        Ok(edges.insert(EdgeStore::new(rate.hz(), usize::MAX, pins)).clone())
    };
    let ran = gcode::begin(bytes.to_vec(), axes, plan, recorder, |mut job| {
        let hz = f64::from(job.rate.hz());
        let mut ways = [0.0; 3].map(Way::from);
        let (path, mut seen) = (job.path, [0; 3]);
        let mut power = plan.laser.map(|_| Way::from(0.0));
        let ended = job.play(fast, &mut Asked(asked), |board, lit| {
            for change in lit {
                let time = change.time.saturating_sub(path) as f64 / hz;
                power.iter_mut().for_each(|power| power.see(time, change.power));
            }
            let now = board.now();
            for axis in 0..3 {
                let at = board.cycle().position(axis as u8).unwrap_or(0);
                if std::mem::replace(&mut seen[axis], at) != at {
                    let rose = board.with_recorder(|edges| edges.take_rise(axis));
                    let time = rose.unwrap_or(now).saturating_sub(path) as f64 / hz;
                    ways[axis].see(time, at as f64 * axes[axis].step);
                }
            }
        });
        let braked = matches!(ended, Ok(PlayEnd::Stopped));
        // A job that only dwells moves nothing.
        let seconds = if job.passed() > 0 { job.passed() as f64 / hz } else { plan.time };
        let error = ended.err();
        let late = job.board.cycle().late();
        let end = job.board.now();
        job.board.with_recorder(|edges| edges.pass(end, &[]));
        let (names, unit) = (NAMES.map(str::to_owned).into(), "mm".to_owned());
        let ways = ways.into();
        Ok::<_, PlayError>((
            Run { names, unit, seconds, late, error, braked, ways, power, ..Run::default() },
            end,
        ))
    });
    let (run, end) = ran.map_err(|why| PyRuntimeError::new_err(why.message))?;
    Ok(Run { pins: edges.map(|edges| edges.record(end as f64, 0.0)), ..run })
}

/// A program that follows a job on a board, and brakes it by Ctrl-C.
struct Watch<'a> {
    asked: Asked<'a>,
    axes: &'a [AxisPace; 3],
    ways: [Way; 3],
}

impl JobWatch for Watch<'_> {
    fn wish(&mut self) -> PlayWish {
        self.asked.wish()
    }

    fn tell(&mut self, place: &Place) {
        for (axis, way) in self.ways.iter_mut().enumerate() {
            way.see(place.seconds, place.steps[axis] as f64 * self.axes[axis].step);
        }
    }
}

/// Runs a planned job on the board at a port, or brakes it after `asked`.
pub fn stream(
    bytes: &[u8],
    axes: [AxisPace; 3],
    plan: &JobPlan,
    (port, baud): (&Path, u32),
    asked: &AtomicBool,
) -> PyResult<Run> {
    let cant = |why: &dyn std::fmt::Display| {
        PyConnectionError::new_err(format!("{}: {why}", port.display()))
    };
    let link = SerialLink::open(port, baud, Share::Alone, |_| LeaseWait::Over);
    let session = Session::new(Box::new(link.map_err(|why| cant(&why))?));
    let lost = |why: PlayError| {
        let hint = why.hint.map_or(String::new(), |hint| format!(" ({hint})"));
        PyConnectionError::new_err(why.message + &hint)
    };
    let mut board = StreamedBoard::meet(session, baud, &Silent(asked)).map_err(lost)?;
    let mut watch = Watch { asked: Asked(asked), axes: &axes, ways: [0.0; 3].map(Way::from) };
    let played = board.play(bytes.to_vec(), axes, plan, &mut watch);
    let seconds =
        watch.ways.iter().filter_map(|way| way.times.last()).fold(0.0f64, |a, b| a.max(*b));
    let (names, unit) = (NAMES.map(str::to_owned).into(), "mm".to_owned());
    let run = Run { names, unit, seconds, ways: watch.ways.into(), ..Run::default() };
    Ok(match played {
        Ok(end) => {
            let (late, braked) = (end.late.try_into().unwrap_or(u32::MAX), end.braked);
            Run { seconds: end.seconds, late, braked, ..run }
        }
        Err(error) => Run { error: Some(error), ..run },
    })
}

/// Plans a path along these places: each a place in mm, and the speed to it in mm/s. The path may be off the
/// lines between them by the tolerance. `axes` are limits as for a job.
#[pyfunction]
pub fn walk(
    py: Python<'_>,
    places: Vec<([f64; 3], f64)>,
    axes: [Pace; 3],
    tolerance: f64,
) -> PyResult<Run> {
    let axes = axes.map(pace);
    let wrong = |number: usize, why: &dyn std::fmt::Display| {
        PyValueError::new_err(format!("waypoint {number}: {why}"))
    };
    playing(py, |asked| {
        let Some(((start, _), rest)) = places.split_first() else {
            return Err(PyValueError::new_err("a path has one place at least"));
        };
        let route = Route::at(axes, *start);
        let mut route = route.map_err(|why| PyValueError::new_err(format!("the axes: {why}")))?;
        let mut fit = ArcFit::new(tolerance)
            .map_err(|why| PyValueError::new_err(format!("tolerance is {tolerance}: {why}")))?;
        let mut ways = start.map(Way::from);
        let mut at = *start;
        let mut take = |route: &mut Route<3>| {
            for step in route.take_while(|_| !asked.load(Ordering::Relaxed)) {
                let axis = step.axis;
                let pace = axes[axis].step;
                // Whole steps, so that a long way has no more rounding than a short way.
                let steps = (at[axis] / pace).round() + if step.forward { 1.0 } else { -1.0 };
                at[axis] = steps * pace;
                ways[axis].see(step.time, at[axis]);
            }
        };
        for (number, (to, feed)) in rest.iter().enumerate() {
            // Ctrl-C ends it; nobody sees the part that is planned.
            if asked.load(Ordering::Relaxed) {
                break;
            }
            fit.line_to(&mut route, *to, *feed, ()).map_err(|why| wrong(number + 1, &why))?;
            while fit.settled().is_some() {}
            take(&mut route);
        }
        fit.settle(&mut route).map_err(|why| wrong(rest.len(), &why))?;
        route.close();
        take(&mut route);
        let (names, unit) = (NAMES.map(str::to_owned).into(), "mm".to_owned());
        let (seconds, ways) = (route.time(), ways.into());
        Ok(Run { names, unit, seconds, ways, ..Run::default() })
    })
}
