//! A planned G-code job: its time, distances and extents.

use std::fs;
use std::io::{Error, ErrorKind};
use std::path::Path;
use std::sync::atomic::Ordering;

use pyo3::exceptions::{PyFileNotFoundError, PyOSError, PyValueError};
use pyo3::prelude::*;
use stepwright_path::{AxisPace, length};
use stepwright_plan::gcode::{JobError, JobPlan, JobTerms};
use stepwright_plan::sheet::SheetFormat;
use stepwright_sim::Description;

use crate::jobs::{self, Pace};
use crate::run::{Run, playing};

/// The board whose limits a job is checked against.
const BOARD: &str = "An Uno";

/// A planned job.
#[pyclass(frozen, module = "stepwright_motion._native")]
pub struct Job {
    plan: JobPlan,
    name: String,
    bytes: Vec<u8>,
    axes: [AxisPace; 3],
}

#[pymethods]
impl Job {
    /// Plans a file for axes with these limits. With a laser, `laser` is its S of full power. The path may be
    /// off its lines by the tolerance in mm.
    #[new]
    #[pyo3(signature = (path, axes, laser, tolerance))]
    fn new(
        py: Python<'_>,
        path: &str,
        axes: [Pace; 3],
        laser: Option<f64>,
        tolerance: f64,
    ) -> PyResult<Job> {
        let unread = |error: Error| {
            let why = format!("can't read {path}: {error}");
            match error.kind() {
                ErrorKind::NotFound => PyFileNotFoundError::new_err(why),
                _ => PyOSError::new_err(why),
            }
        };
        let bytes = fs::read(path).map_err(unread)?;
        let axes = axes.map(jobs::pace);
        let board = Description::uno().board;
        let given = length(tolerance).filter(|_| (0.0..=1e3).contains(&tolerance));
        let tolerance = given.ok_or_else(|| {
            PyValueError::new_err(format!("tolerance is {tolerance}: it may be 0 to 1000 mm"))
        })?;
        let terms = JobTerms { laser, tolerance };
        let plan = playing(py, |asked| {
            // Ctrl-C ends the job after the part that was read.
            let read = bytes.iter().copied().take_while(|_| !asked.load(Ordering::Relaxed));
            JobPlan::on(read, axes, &terms, &board, |_, _| ()).map_err(|error| {
                let place = match &error {
                    JobError::Code(code) => format!("{path}:{}:{}", code.line, code.column),
                    JobError::Move(line, _) => format!("{path}:{line}"),
                };
                PyValueError::new_err(format!("{place}: {error}"))
            })
        })?;
        Ok(Job { plan, name: path.to_owned(), bytes, axes })
    }

    /// Seconds from the start to the end.
    #[getter]
    fn duration(&self) -> f64 {
        self.plan.time
    }

    /// The lines read.
    #[getter]
    fn lines(&self) -> u32 {
        self.plan.survey.lines
    }

    /// The extents of the moves in mm: from and to of X, Y and Z.
    #[getter]
    fn extents(&self) -> [Option<(f64, f64)>; 3] {
        self.plan.survey.extents.0.map(|axis| axis.map(|[from, to]| (from, to)))
    }

    /// The corners that cost most: line, place in mm, speed in mm/s, cost in s.
    #[getter]
    fn corners(&self) -> Vec<(u32, [f64; 3], f64, f64)> {
        let corners = self.plan.corners.iter();
        corners.map(|corner| (corner.line, corner.place, corner.speed, corner.cost)).collect()
    }

    /// Why an Uno can't follow; `None` if it can.
    #[getter]
    fn refused(&self) -> Option<String> {
        self.plan.refused.map(|refused| refused.words(BOARD))
    }

    /// Runs the job on the board at a port, or on a virtual board, in real time unless `fast`.
    #[pyo3(signature = (port, baud, fast))]
    fn run(&self, py: Python<'_>, port: Option<String>, baud: u32, fast: bool) -> PyResult<Run> {
        let (bytes, axes, plan) = (&self.bytes, self.axes, &self.plan);
        playing(py, |asked| match port {
            Some(port) => jobs::stream(bytes, axes, plan, (Path::new(&port), baud), asked),
            None => jobs::play(bytes, axes, plan, fast, asked),
        })
    }

    /// The whole plan as the command prints it: `table` or `json`.
    fn sheet(&self, json: bool) -> PyResult<String> {
        let format = if json { SheetFormat::Json } else { SheetFormat::Table };
        let mut out = Vec::new();
        let sheet = self.plan.sheet(format!("G-code job {}", self.name), BOARD);
        sheet.write(&mut out, format)?;
        Ok(String::from_utf8_lossy(&out).into_owned())
    }
}
