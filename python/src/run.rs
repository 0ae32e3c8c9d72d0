//! The motion of the motors by a file: their positions over time, and every edge of their pins.

use std::fmt::Display;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use stepwright_keeper::scope::{ScopeFile, ScopeRecord};
use stepwright_play::{PlayError, PlayVoice};

/// How often a waiting thread looks for Ctrl-C.
const SLICE: Duration = Duration::from_millis(20);

/// The positions of a motor over time.
#[derive(Clone, Debug, Default)]
pub struct Way {
    /// Times in s.
    pub times: Vec<f64>,
    /// Positions in the unit of the run.
    pub places: Vec<f64>,
}

impl Way {
    /// A motor that rests at a place.
    pub fn from(place: f64) -> Way {
        Way { times: vec![0.0], places: vec![place] }
    }

    /// Adds a place if it differs from the last one.
    pub fn see(&mut self, time: f64, place: f64) {
        if self.is_elsewhere(place) {
            self.times.push(time);
            self.places.push(place);
        }
    }

    /// Whether a place differs from the last one.
    pub fn is_elsewhere(&self, place: f64) -> bool {
        self.places.last() != Some(&place)
    }

    /// Times and places as doubles.
    fn columns<'py>(&self, py: Python<'py>) -> [Bound<'py, PyByteArray>; 2] {
        [&self.times, &self.places].map(|values| {
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
            PyByteArray::new(py, &bytes)
        })
    }
}

/// A run of a file.
#[pyclass(frozen, module = "stepwright_motion._native")]
#[derive(Default)]
pub struct Run {
    pub names: Vec<String>,
    pub unit: String,
    /// Seconds from the start to the end.
    pub seconds: f64,
    /// The number of late steps.
    pub late: u32,
    /// The result as the command's JSON, if there is one.
    pub facts: Option<String>,
    /// Why the run did not reach its end, and a remedy.
    pub error: Option<PlayError>,
    /// Whether the run was braked.
    pub braked: bool,
    pub ways: Vec<Way>,
    /// The powers of a laser, as places.
    pub power: Option<Way>,
    pub pins: Option<ScopeRecord>,
}

#[pymethods]
impl Run {
    /// The motors' names.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    /// The unit of positions.
    #[getter]
    fn unit(&self) -> &str {
        &self.unit
    }

    /// Seconds from the start to the end.
    #[getter]
    fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The number of late steps.
    #[getter]
    fn late(&self) -> u32 {
        self.late
    }

    /// The result as the command's JSON.
    #[getter]
    fn facts(&self) -> Option<&str> {
        self.facts.as_deref()
    }

    /// Why the run did not reach its end, and a remedy.
    #[getter]
    fn error(&self) -> Option<(&str, Option<&str>)> {
        self.error.as_ref().map(|error| (error.message.as_str(), error.hint.as_deref()))
    }

    /// Whether the run was braked before its end.
    #[getter]
    fn braked(&self) -> bool {
        self.braked
    }

    /// The columns of a motor, counted from 0: times and positions as doubles.
    fn columns<'py>(
        &self,
        py: Python<'py>,
        motor: usize,
    ) -> PyResult<[Bound<'py, PyByteArray>; 2]> {
        let way = self.ways.get(motor).ok_or_else(|| PyValueError::new_err("no such motor"))?;
        Ok(way.columns(py))
    }

    /// The columns of a laser: times and powers as doubles.
    fn power<'py>(&self, py: Python<'py>) -> Option<[Bound<'py, PyByteArray>; 2]> {
        self.power.as_ref().map(|power| power.columns(py))
    }

    /// The pins as a file: `vcd`, `csv`, `mcap`.
    fn pins<'py>(&self, py: Python<'py>, ending: &str) -> PyResult<Bound<'py, PyByteArray>> {
        let kind = ScopeFile::named(ending);
        let kind = kind.ok_or_else(|| PyValueError::new_err("it is vcd, csv or mcap"))?;
        let record = self.pins.as_ref();
        let record = record.ok_or_else(|| PyValueError::new_err("nobody has seen its pins"))?;
        Ok(PyByteArray::new(py, &kind.of(record)?))
    }
}

/// Prints nothing, and ends when asked to.
pub struct Silent<'a>(pub &'a AtomicBool);

impl PlayVoice for Silent<'_> {
    fn result(&self, _: &dyn Display) {}

    fn note(&self, _: &dyn Display) {}

    fn asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Plays or plans something on a separate thread while this thread looks for Ctrl-C. Ctrl-C asks `part` to end,
/// and is raised after that.
pub fn playing<T: Send>(
    py: Python<'_>,
    part: impl FnOnce(&AtomicBool) -> PyResult<T> + Send,
) -> PyResult<T> {
    let asked = AtomicBool::new(false);
    let mut raised = None;
    let played = thread::scope(|scope| {
        let (ended, ends) = channel::<()>();
        let asked = &asked;
        let player = scope.spawn(move || {
            let _ended = ended;
            part(asked)
        });
        let mut ends = Some(ends);
        while let Some(end) = ends.take() {
            let (over, end) = py.detach(move || {
                let heard = end.recv_timeout(SLICE);
                (heard != Err(RecvTimeoutError::Timeout), end)
            });
            if let Err(interrupted) = py.check_signals() {
                asked.store(true, Ordering::Relaxed);
                raised = Some(interrupted);
            }
            ends = (!over).then_some(end);
        }
        py.detach(|| player.join())
    });
    if let Some(interrupted) = raised {
        return Err(interrupted);
    }
    played.unwrap_or_else(|_| Err(PyRuntimeError::new_err("the player has failed")))
}
