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
//! A conversation is a future of the compiler's making, which waits for nothing else than a byte
//! or a time. Whoever has bytes and a clock can carry it on: [`Session`](crate::Session) does so
//! with a thread that blocks, a page with its events.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::io::{Error, ErrorKind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::Poll;
use std::time::Duration;

use crate::conversation::LinkError;

/// Both ends of a line; a clone is the same line.
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
    /// A line on which nothing was said, at time 0.
    pub fn new() -> Pipe {
        Pipe::default()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // A panic leaves no state half written.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// It is this time now, of any clock that never goes back.
    pub fn pass(&self, now: Duration) {
        let mut state = self.state();
        state.now = state.now.max(now);
    }

    /// These bytes have come from the board.
    pub fn feed(&self, bytes: &[u8]) {
        self.state().incoming.extend(bytes);
    }

    /// The line is gone: whoever waits for a byte hears so.
    pub fn lose(&self, error: Error) {
        self.state().gone = Some(error);
    }

    /// The bytes to be sent to the board.
    pub fn take_output(&self) -> Vec<u8> {
        std::mem::take(&mut self.state().outgoing)
    }

    /// When to go on though no byte has come; `None` if nobody waits.
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

    /// What has come is to nothing that was asked.
    pub(crate) fn forget_incoming(&self) {
        self.state().incoming.clear();
    }

    /// The next byte, at this time at the latest; `None` if none has come by then.
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

    /// Waits until this time. What comes meanwhile is noise.
    pub(crate) async fn rest_until(&self, until: Duration) -> Result<(), LinkError> {
        while self.byte_until(until).await?.is_some() {}
        Ok(())
    }
}

/// The same error for the next who asks.
fn again(error: &Error) -> Error {
    match error.kind() {
        ErrorKind::Other => Error::other(error.to_string()),
        kind if error.raw_os_error().is_none() => kind.into(),
        _ => error.raw_os_error().map_or_else(|| error.kind().into(), Error::from_raw_os_error),
    }
}
