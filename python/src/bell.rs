//! Calls Python back from a thread of its own, so that no board waits for the interpreter.

use std::thread;

use pyo3::prelude::*;

/// Calls these, one after the other, as soon as the interpreter is free. The thread ends with that:
/// a process that is forked off has none of those that wait for more.
pub fn ring(calls: Vec<Py<PyAny>>) {
    if calls.is_empty() {
        return;
    }
    thread::spawn(move || {
        // None: the interpreter has ended, and nobody waits.
        Python::try_attach(|py| {
            for call in calls {
                // The loop that was to be told may be closed.
                let _ = call.call0(py);
            }
        });
    });
}
