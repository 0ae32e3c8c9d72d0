//! Speaking to the user without ever falling over.
//!
//! `println!` panics when nobody listens any more; a command that holds a
//! motor must not. Results go to standard output, the rest to standard error.

use std::fmt::Display;
use std::io::{self, Write};

/// A line on standard output.
///
/// If it can't be written there is nobody to be told, and the motor comes
/// first: the error is dropped.
pub fn result(line: impl Display) {
    let mut out = io::stdout().lock();
    let _ = writeln!(out, "{line}").and_then(|()| out.flush());
}

/// A line on standard error.
pub fn note(line: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}
