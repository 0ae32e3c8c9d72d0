//! Output to the user that never panics.
//!
//! `println!` panics if the reader has closed its end; a command that controls a motor must not
//! panic. Results go to standard output, all else to standard error.

use std::fmt::Display;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::Value;

/// Whether a result could not be written.
static LOST: AtomicBool = AtomicBool::new(false);

/// Prints a line on standard output.
///
/// The motor has priority over an error of writing: the command continues, and its exit status
/// reports the error ([`lost`]). A reader that closes early (`| head`) is no failure.
pub fn result(line: impl Display) {
    let mut out = io::stdout().lock();
    if let Err(error) = writeln!(out, "{line}").and_then(|()| out.flush())
        && error.kind() != io::ErrorKind::BrokenPipe
        && !LOST.swap(true, Ordering::Relaxed)
    {
        note(format_args!("error: can't write to standard output: {error}"));
    }
}

/// Prints a line of JSON on standard output, with fractions rounded to 12 digits.
pub fn json(value: Value) {
    result(stepwright_plan::tidy(value));
}

/// Whether a result could not be written to standard output.
pub fn lost() -> bool {
    LOST.load(Ordering::Relaxed)
}

/// Prints a line on standard error.
pub fn note(line: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}
