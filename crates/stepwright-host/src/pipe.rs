//! The line of a [`Conversation`](crate::Conversation) without any I/O: bytes and time go in,
//! bytes and a deadline come out.
//!
//! ```text
//!   the world                     Pipe                      the conversation
//!   pass(now), feed(bytes) ──►  incoming  ──► byte_until(deadline).await
//!   take_output()          ◄──  outgoing  ◄── write(bytes)
//!   deadline()             ◄──  what it waits for
//! ```
//!
//! A conversation is a future that waits only for a byte or a time. Whoever has bytes and a clock can run it:
//! [`Session`](crate::Session) does so with a thread that blocks, a web page with its events.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::io::{Error, ErrorKind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::Poll;
use std::time::Duration;

use crate::conversation::LinkError;

/// Both ends of a line; clones are the same line.
#[derive(Clone, Default)]
pub struct Pipe(Arc<Mutex<State>>);

#[derive(Default)]
struct State {
    now: Duration,
    incoming: VecDeque<u8>,
    outgoing: Vec<u8>,
    until: Option<Duration>,
    gone: Option<Error>,
}

impl Pipe {
    /// A line without bytes, at time 0.
    pub fn new() -> Pipe {
        Pipe::default()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // No change can panic half-way.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sets the present time, of any clock that never goes back.
    pub fn pass(&self, now: Duration) {
        let mut state = self.state();
        state.now = state.now.max(now);
    }

    /// Adds bytes from the board.
    pub fn feed(&self, bytes: &[u8]) {
        self.state().incoming.extend(bytes);
    }

    /// Notes that the line is gone. Whoever waits for a byte gets the error.
    pub fn lose(&self, error: Error) {
        self.state().gone = Some(error);
    }

    /// Takes the bytes for the board.
    pub fn take_output(&self) -> Vec<u8> {
        std::mem::take(&mut self.state().outgoing)
    }

    /// When to go on even if no byte comes; `None` if the conversation waits for nothing.
    pub fn deadline(&self) -> Option<Duration> {
        self.state().until
    }

    /// The present time.
    pub(crate) fn now(&self) -> Duration {
        self.state().now
    }

    pub(crate) fn write(&self, bytes: impl IntoIterator<Item = u8>) {
        self.state().outgoing.extend(bytes);
    }

    /// Drops the bytes that have come.
    pub(crate) fn forget_incoming(&self) {
        self.state().incoming.clear();
    }

    /// The next byte; `None` if none comes until this time.
    pub(crate) async fn byte_until(&self, until: Duration) -> Result<Option<u8>, LinkError> {
        let outcome = poll_fn(|_| {
            let mut state = self.state();
            let outcome = if let Some(byte) = state.incoming.pop_front() {
                Ok(Some(byte))
            } else if let Some(error) = &state.gone {
                Err(LinkError::Gone(again(error)))
            } else if state.now >= until {
                Ok(None)
            } else {
                state.until = Some(until);
                return Poll::Pending;
            };
            state.until = None;
            Poll::Ready(outcome)
        });
        outcome.await
    }

    /// Waits until this time, and drops bytes that come meanwhile.
    pub(crate) async fn rest_until(&self, until: Duration) -> Result<(), LinkError> {
        while self.byte_until(until).await?.is_some() {}
        Ok(())
    }
}

/// A copy of the error, for the next caller.
fn again(error: &Error) -> Error {
    match error.kind() {
        ErrorKind::Other => Error::other(error.to_string()),
        kind if error.raw_os_error().is_none() => kind.into(),
        _ => error.raw_os_error().map_or_else(|| error.kind().into(), Error::from_raw_os_error),
    }
}
