//! Calls Python back from a separate thread, so that no board waits for the interpreter.

use std::thread;

use pyo3::prelude::*;

/// Calls these one after the other as soon as the interpreter is free. The thread then ends: a forked process
/// has no thread that waits for more.
pub fn ring(calls: Vec<Py<PyAny>>) {
    if calls.is_empty() {
        return;
    }
    thread::spawn(move || {
        // `None`: the interpreter has ended, and nobody waits.
        Python::try_attach(|py| {
            for call in calls {
                // The event loop of the call may be closed.
                let _ = call.call0(py);
            }
        });
    });
}
