//! An order that was given, and what becomes of it.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use stepwright_keeper::Declined;
use stepwright_keeper::report::Done;

use crate::bell;

/// An order, from the moment when it was given.
#[derive(Default)]
pub struct Ticket {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    begun: bool,
    ended: Option<Result<Done, Declined>>,
    /// Whether the time of the run was over, and it was braked for that.
    over: bool,
    calls: Vec<Py<PyAny>>,
}

/// How far an order is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// It has begun, or was declined.
    Begun,
    /// It has ended, or was declined.
    Ended,
}

impl Ticket {
    fn state(&self) -> MutexGuard<'_, State> {
        // Nothing here is changed by halves.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The motors move.
    pub fn begin(&self) {
        self.state().begun = true;
        self.changed.notify_all();
    }

    /// It has ended so.
    pub fn end(&self, answer: Result<Done, Declined>) {
        let mut state = self.state();
        state.ended = Some(answer);
        let calls = std::mem::take(&mut state.calls);
        drop(state);
        self.changed.notify_all();
        bell::ring(calls);
    }

    /// Whether it has come so far.
    pub fn is(&self, stage: Stage) -> bool {
        let state = self.state();
        state.ended.is_some() || stage == Stage::Begun && state.begun
    }

    /// Waits until it has come so far, for this time at most; whether it has.
    pub fn wait(&self, stage: Stage, limit: Duration) -> bool {
        let state = self.state();
        let waits =
            |state: &mut State| state.ended.is_none() && !(stage == Stage::Begun && state.begun);
        let waited = self.changed.wait_timeout_while(state, limit, waits);
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// What has become of it; `None` while it goes on.
    pub fn answer(&self) -> Option<Result<Done, Declined>> {
        self.state().ended.clone()
    }

    /// Its time is over.
    pub fn time_is_over(&self) {
        self.state().over = true;
    }

    /// Whether it was braked because its time was over.
    pub fn was_timed(&self) -> bool {
        self.state().over
    }

    /// Has this called when it has ended: at once, if it has.
    pub fn when_ended(&self, call: Py<PyAny>) {
        let mut state = self.state();
        if state.ended.is_none() {
            state.calls.push(call);
            return;
        }
        drop(state);
        bell::ring(vec![call]);
    }
}
