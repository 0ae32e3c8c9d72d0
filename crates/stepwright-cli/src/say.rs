//! Speaking to the user without ever falling over.
//!
//! `println!` panics when nobody listens any more; a command that holds a
//! motor must not. Results go to standard output, the rest to standard error.

use std::fmt::Display;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::Value;

/// Whether a result could not be written.
static LOST: AtomicBool = AtomicBool::new(false);

/// A line on standard output.
///
/// If it can't be written the motor comes first: the command goes on, and its
/// exit status says so ([`lost`]). A reader that has heard enough (`| head`)
/// is no failure.
pub fn result(line: impl Display) {
    let mut out = io::stdout().lock();
    if let Err(error) = writeln!(out, "{line}").and_then(|()| out.flush())
        && error.kind() != io::ErrorKind::BrokenPipe
        && !LOST.swap(true, Ordering::Relaxed)
    {
        note(format_args!("error: can't write to standard output: {error}"));
    }
}

/// A line of JSON on standard output, its numbers without noise.
pub fn json(value: Value) {
    result(stepwright_plan::tidy(value));
}

/// Whether a result was lost on its way to standard output.
pub fn lost() -> bool {
    LOST.load(Ordering::Relaxed)
}

/// A line on standard error.
pub fn note(line: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}
