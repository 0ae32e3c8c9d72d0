//! The classes that Python holds: a kept board, an order, a recorder.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use serde::Serialize;
use stepwright_keeper::scope::{ScopeFile, ScopeRecord, ScopeSource};
use stepwright_keeper::{Declined, Job, KeeperDesk, Wish, asked};
use stepwright_protocol::{LeaseMillis, Selection};
use stepwright_sim::Switch;

use crate::desk::{Awaited, Desk, HAND, Met, Probe};
use crate::keeping::{self, Way};
use crate::ticket::{Stage, Ticket};
use crate::track::Tracks;

/// How often a waiting thread looks for Ctrl-C.
const SLICE: Duration = Duration::from_millis(50);

/// An answer for Python: the HTTP status that it would have, and its JSON.
type Answer = (u16, String);

fn json(value: &impl Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| PyRuntimeError::new_err(error.to_string()))
}

fn declined(why: &Declined) -> PyResult<Answer> {
    Ok((why.status(), json(why)?))
}

/// Calls `part` with slices of time until it is true, without blocking other threads. False after `limit`.
fn wait(
    py: Python<'_>,
    limit: Option<f64>,
    mut part: impl FnMut(Duration) -> bool + Send,
) -> PyResult<bool> {
    let limit =
        limit.map(|limit| Duration::try_from_secs_f64(limit.max(0.0)).unwrap_or(Duration::MAX));
    let began = Instant::now();
    loop {
        let left = limit.map(|limit| limit.saturating_sub(began.elapsed()));
        let slice = left.map_or(SLICE, |left| left.min(SLICE));
        if py.detach(|| part(slice)) {
            return Ok(true);
        }
        py.check_signals()?;
        if left.is_some_and(|left| left.is_zero()) {
            return Ok(false);
        }
    }
}

/// A wait that ends when it is dropped.
struct Waiter<'d>(&'d Desk, u64);

impl<'d> Waiter<'d> {
    fn new(desk: &'d Desk, what: Awaited) -> Waiter<'d> {
        Waiter(desk, desk.waits_for(what))
    }
}

impl Drop for Waiter<'_> {
    fn drop(&mut self) {
        self.0.forgo(self.1);
    }
}

/// A board that is kept by a thread. Its motors brake when this is dropped.
#[pyclass(frozen, module = "stepwright_motion._native")]
pub struct Kept {
    desk: Arc<Desk>,
    /// The process that opened the board. A forked process does not have the thread.
    process: u32,
}

impl Kept {
    fn desk(&self) -> PyResult<&Arc<Desk>> {
        if self.process == process::id() {
            return Ok(&self.desk);
        }
        Err(PyRuntimeError::new_err("the board was opened by another process: open it in this one"))
    }
}

impl Drop for Kept {
    fn drop(&mut self) {
        if self.process == process::id() {
            self.desk.leave();
        }
    }
}

#[pymethods]
impl Kept {
    /// Begins to open a board: a port, `tcp://HOST:PORT`, or a virtual board without a port.
    #[staticmethod]
    #[pyo3(signature = (port, baud, lease_ms, fast, switches))]
    fn open(
        port: Option<String>,
        baud: u32,
        lease_ms: u32,
        fast: bool,
        switches: Vec<String>,
    ) -> PyResult<Kept> {
        let lease = LeaseMillis::new(lease_ms).filter(|_| lease_ms >= 200);
        let lease = lease.ok_or_else(|| PyValueError::new_err("a lease lasts from 0.2 to 60 s"))?;
        let way = match port {
            Some(port) => match port.strip_prefix("tcp://") {
                Some(address) => Way::Tcp(address.to_owned()),
                None => Way::Port(port.into(), baud),
            },
            None => {
                let read = |text: &String| text.parse::<Switch>();
                let switches = switches.iter().map(read).collect::<Result<_, _>>();
                let switches = switches.map_err(PyValueError::new_err)?;
                Way::Virtual { fast, switches }
            }
        };
        let fast = matches!(way, Way::Virtual { fast: true, .. });
        let desk = Arc::new(Desk::new(fast));
        let kept = Kept { desk: desk.clone(), process: process::id() };
        let thread = thread::Builder::new().name("stepwright".to_owned());
        thread.spawn(move || keeping::keep(&way, lease, desk))?;
        Ok(kept)
    }

    /// Waits until the board is met. Returns the reason if it is not.
    fn meet(&self, py: Python<'_>) -> PyResult<Option<Answer>> {
        let desk = self.desk()?;
        let met = |slice| desk.wait(slice, |met, _| !matches!(met, Met::NotYet));
        if let Err(interrupted) = wait(py, None, met) {
            desk.leave();
            return Err(interrupted);
        }
        match desk.met() {
            Met::Ended(Some(why)) => declined(&why).map(Some),
            _ => Ok(None),
        }
    }

    /// Asks the board's thread for something, as JSON. With `waits` the answer comes at the end of the order. A
    /// run ends after `seconds`.
    #[pyo3(signature = (name, body, waits=false, seconds=None))]
    fn ask(
        &self,
        py: Python<'_>,
        name: &str,
        body: &str,
        waits: bool,
        seconds: Option<f64>,
    ) -> PyResult<Order> {
        let desk = self.desk()?;
        let ticket = Arc::new(Ticket::default());
        let order = Order { desk: desk.clone(), ticket: ticket.clone(), process: self.process };
        let wish = match asked::wish(name, body, HAND) {
            Ok((wish, _)) => wish,
            Err(why) => {
                ticket.end(Err(why));
                return Ok(order);
            }
        };
        let stop = match (&wish, seconds) {
            (Wish::Run(axis, ..), Some(seconds)) => {
                Some((seconds, Wish::Stop(Selection::One(*axis))))
            }
            _ => None,
        };
        let (holder, at) = (Holder(ticket.clone()), desk.clone());
        let job = Job::new(wish, waits, move |answer| holder.0.end(answer)).when_begun(move || {
            if let Some((seconds, stop)) = stop {
                at.end_at(at.time() + seconds, ticket.clone(), stop);
            }
            ticket.begin();
        });
        py.detach(|| desk.put(job));
        Ok(order)
    }

    /// The state of the board as JSON.
    fn state(&self) -> PyResult<String> {
        json(&self.desk()?.state())
    }

    /// The description of the board as JSON.
    fn sheet(&self) -> PyResult<String> {
        json(&self.desk()?.sheet())
    }

    /// Takes the notes for people. Each is returned once.
    fn notes(&self) -> PyResult<Vec<String>> {
        Ok(self.desk()?.take_notes())
    }

    /// Seconds since the board was opened.
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.desk()?.time())
    }

    /// Whether the board takes no more orders because it was closed or lost.
    #[getter]
    fn ended(&self) -> PyResult<bool> {
        Ok(matches!(self.desk()?.met(), Met::Ended(_)))
    }

    /// Lets time pass on the board.
    fn sleep(&self, py: Python<'_>, seconds: f64) -> PyResult<()> {
        let desk = self.desk()?;
        let end = desk.time() + seconds;
        let _waiter = Waiter::new(desk, Awaited::Time(end));
        let over = |met: &Met, now: f64| now >= end || matches!(met, Met::Ended(_));
        wait(py, None, |slice| desk.wait(slice, over))?;
        Ok(())
    }

    /// Brakes all motors, waits until they rest, and ends the thread. Returns the reason if that is not known.
    fn close(&self, py: Python<'_>) -> PyResult<Option<Answer>> {
        let desk = self.desk()?;
        desk.leave();
        wait(py, None, |slice| desk.wait(slice, |met, _| matches!(met, Met::Ended(_))))?;
        match desk.met() {
            Met::Ended(Some(why)) => declined(&why).map(Some),
            _ => Ok(None),
        }
    }

    /// Begins to record the axes.
    fn record(&self) -> PyResult<Recorder> {
        let desk = self.desk()?.clone();
        let tracks = Arc::new(Tracks::default());
        desk.record(&tracks);
        Ok(Recorder::begin(desk, tracks))
    }
}

/// Ends its order in any case.
struct Holder(Arc<Ticket>);

impl Drop for Holder {
    fn drop(&mut self) {
        if !self.0.is(Stage::Ended) {
            self.0.end(Err(Declined::away("the thread of the board has ended")));
        }
    }
}

/// A given order.
#[pyclass(frozen, module = "stepwright_motion._native")]
pub struct Order {
    desk: Arc<Desk>,
    ticket: Arc<Ticket>,
    process: u32,
}

impl Order {
    /// Refuses to wait in a forked process, which would never learn of the end.
    fn check(&self) -> PyResult<()> {
        if self.process == process::id() {
            return Ok(());
        }
        Err(PyRuntimeError::new_err("the order was given by another process"))
    }
}

#[pymethods]
impl Order {
    /// Waits until the order has begun or was declined.
    fn begun(&self, py: Python<'_>) -> PyResult<bool> {
        wait(py, None, |slice| self.ticket.wait(Stage::Begun, slice))
    }

    /// Waits until the order has ended, for at most `timeout` seconds of real time. Returns whether it has.
    #[pyo3(signature = (timeout=None))]
    fn wait(&self, py: Python<'_>, timeout: Option<f64>) -> PyResult<bool> {
        self.check()?;
        let _waiter = Waiter::new(&self.desk, Awaited::End(self.ticket.clone()));
        wait(py, timeout, |slice| self.ticket.wait(Stage::Ended, slice))
    }

    /// The result of the order; `None` while it is in progress.
    fn answer(&self) -> PyResult<Option<Answer>> {
        match self.ticket.answer() {
            None => Ok(None),
            Some(Ok(done)) => Ok(Some((200, json(&done)?))),
            Some(Err(why)) => declined(&why).map(Some),
        }
    }

    /// Whether the order was braked because its time was over.
    #[getter]
    fn timed(&self) -> bool {
        self.ticket.was_timed()
    }

    /// Calls this from another thread when the order has ended.
    fn when_ended(&self, call: Py<PyAny>) -> PyResult<()> {
        self.check()?;
        self.ticket.when_ended(call);
        self.desk.waits_for(Awaited::End(self.ticket.clone()));
        Ok(())
    }
}

/// Records the axes.
#[pyclass(frozen, module = "stepwright_motion._native")]
pub struct Recorder {
    desk: Arc<Desk>,
    tracks: Arc<Tracks>,
    began: f64,
    /// The pins, after the recording has ended.
    pins: Mutex<Option<ScopeRecord>>,
    ended: AtomicBool,
    /// The process that began it. In a forked process another thread's locks may be held for ever.
    process: u32,
}

impl Recorder {
    fn begin(desk: Arc<Desk>, tracks: Arc<Tracks>) -> Recorder {
        if let Some(Probe::Pins(edges)) = desk.probed() {
            edges.begin();
        }
        let (began, pins) = (desk.time(), Mutex::new(None));
        let ended = AtomicBool::new(false);
        Recorder { desk, tracks, began, pins, ended, process: process::id() }
    }

    fn check(&self) -> PyResult<()> {
        if self.process == process::id() {
            return Ok(());
        }
        Err(PyRuntimeError::new_err("the recording was begun by another process"))
    }

    /// The pins from the begin of the recording until now.
    fn look(&self) -> Option<ScopeRecord> {
        let now = self.desk.time();
        let long = now - self.began;
        self.desk.probed().map(|probe| match probe {
            Probe::Pins(edges) => edges.record(long, now),
            Probe::Plans(plans) => plans.record(long, now),
        })
    }

    fn end(&self) {
        if self.ended.swap(true, Ordering::SeqCst) {
            return;
        }
        self.desk.end_record(&self.tracks);
        *self.pins.lock().unwrap_or_else(PoisonError::into_inner) = self.look();
        if let Some(Probe::Pins(edges)) = self.desk.probed() {
            edges.end();
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        if self.check().is_ok() {
            self.end();
        }
    }
}

#[pymethods]
impl Recorder {
    /// Ends the recording.
    fn stop(&self) -> PyResult<()> {
        self.check()?;
        self.end();
        Ok(())
    }

    /// The pins as a file: `vcd`, `csv`, `mcap`.
    fn pins<'py>(&self, py: Python<'py>, ending: &str) -> PyResult<Bound<'py, PyByteArray>> {
        let kind = ScopeFile::named(ending);
        let kind = kind.ok_or_else(|| PyValueError::new_err("it is vcd, csv or mcap"))?;
        let ended = self.pins.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let record = ended.or_else(|| self.look()).unwrap_or_default();
        Ok(PyByteArray::new(py, &kind.of(&record)?))
    }

    /// The number of axes that were seen.
    #[getter]
    fn axes(&self) -> usize {
        self.tracks.len()
    }

    /// The number of looks at an axis, counted from 0, that did not come in time.
    fn missed(&self, axis: usize) -> u64 {
        self.tracks.of(axis).missed
    }

    /// The columns of an axis, counted from 0: time, position and speed as doubles, state as bytes.
    fn columns<'py>(&self, py: Python<'py>, axis: usize) -> [Bound<'py, PyByteArray>; 4] {
        let track = self.tracks.of(axis);
        let doubles = |values: &[f64]| {
            let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
            PyByteArray::new(py, &bytes)
        };
        [
            doubles(&track.time),
            doubles(&track.position),
            doubles(&track.speed),
            PyByteArray::new(py, &track.state),
        ]
    }
}
