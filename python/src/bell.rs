//! Calls Python back from a thread of its own, so that no board waits for the interpreter.

use std::sync::OnceLock;
use std::sync::mpsc::{Sender, channel};
use std::thread;

use pyo3::prelude::*;

/// Calls these, one after the other, as soon as the interpreter is free.
pub fn ring(calls: Vec<Py<PyAny>>) {
    static BELL: OnceLock<Sender<Py<PyAny>>> = OnceLock::new();
    if calls.is_empty() {
        return;
    }
    let bell = BELL.get_or_init(|| {
        let (bell, rung) = channel::<Py<PyAny>>();
        thread::spawn(move || {
            for call in rung {
                // None: the interpreter has ended, and nobody waits.
                Python::try_attach(|py| {
                    // The loop that was to be told may be closed.
                    let _ = call.call0(py);
                    drop(call);
                });
            }
        });
        bell
    });
    for call in calls {
        let _ = bell.send(call);
    }
}
