//! A given order and its result.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use stepwright_keeper::Declined;
use stepwright_keeper::report::Done;

use crate::bell;

/// An order from the moment at which it was given.
#[derive(Default)]
pub struct Ticket {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    begun: bool,
    ended: Option<Result<Done, Declined>>,
    /// Whether the run was braked because its time was over.
    over: bool,
    calls: Vec<Py<PyAny>>,
}

/// The progress of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The order has begun or was declined.
    Begun,
    /// The order has ended or was declined.
    Ended,
}

impl Ticket {
    fn state(&self) -> MutexGuard<'_, State> {
        // Every change leaves a complete state.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes that the motors move.
    pub fn begin(&self) {
        self.state().begun = true;
        self.changed.notify_all();
    }

    /// Notes the result of the order.
    pub fn end(&self, answer: Result<Done, Declined>) {
        let mut state = self.state();
        state.ended = Some(answer);
        let calls = std::mem::take(&mut state.calls);
        drop(state);
        self.changed.notify_all();
        bell::ring(calls);
    }

    /// Whether the order has reached this stage.
    pub fn is(&self, stage: Stage) -> bool {
        let state = self.state();
        state.ended.is_some() || stage == Stage::Begun && state.begun
    }

    /// Waits until the order has reached this stage, for at most `limit`. Returns whether it has.
    pub fn wait(&self, stage: Stage, limit: Duration) -> bool {
        let state = self.state();
        let waits =
            |state: &mut State| state.ended.is_none() && !(stage == Stage::Begun && state.begun);
        let waited = self.changed.wait_timeout_while(state, limit, waits);
        !waited.unwrap_or_else(PoisonError::into_inner).1.timed_out()
    }

    /// The result; `None` while the order is in progress.
    pub fn answer(&self) -> Option<Result<Done, Declined>> {
        self.state().ended.clone()
    }

    /// Notes that the time of the run is over.
    pub fn time_is_over(&self) {
        self.state().over = true;
    }

    /// Whether it was braked because its time was over.
    pub fn was_timed(&self) -> bool {
        self.state().over
    }

    /// Calls this when the order has ended; at once, if it has.
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
