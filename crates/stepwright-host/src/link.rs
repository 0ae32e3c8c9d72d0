//! The way to a board: a serial port, a socket, a virtual board in this process, or through another
//! program that holds the port.
//!
//! All carry bytes and nothing else, so that all that is said to a virtual
//! board is said on the real line.

#[cfg(all(unix, feature = "serial"))]
mod door;
#[cfg(all(unix, feature = "serial"))]
pub mod guest;
#[cfg(all(unix, feature = "serial"))]
pub mod host;
#[cfg(all(unix, feature = "serial"))]
pub mod lease;
pub mod lossy;
#[cfg(feature = "virtual")]
pub mod pace;
#[cfg(feature = "serial")]
pub mod serial;
#[cfg(feature = "virtual")]
pub mod simulated;
pub mod tcp;

use std::fmt;
use std::io;
use std::thread;
use std::time::Duration;

/// Why there is no line to a board.
#[derive(Debug)]
pub enum OpenError {
    /// Another program that asks before opening has it.
    InUse,
    /// The waiting for a lease that a dead holder has left was ended.
    Ended,
    /// The system refuses it.
    Io(io::Error),
}

impl fmt::Display for OpenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            OpenError::InUse => f.write_str("the port is in use"),
            OpenError::Ended => f.write_str("interrupted before a line was said"),
            OpenError::Io(error) => write!(f, "can't open the port: {error}"),
        }
    }
}

impl std::error::Error for OpenError {}

/// A line to a board, with the clock that waiting is measured by.
pub trait Link {
    /// Puts bytes on the line.
    ///
    /// # Errors
    /// The line is gone, or it takes no byte for a while
    /// ([`io::ErrorKind::TimedOut`]).
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Waits until bytes come, at most `limit`. The number of bytes; 0 if none
    /// came in that time.
    ///
    /// # Errors
    /// The line is gone.
    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize>;

    /// Time since the line was opened: the board's own, where it has one.
    fn now(&self) -> Duration;

    /// How to call the board in a sentence: `the virtual board`.
    fn name(&self) -> String;

    /// Whether no other program that asks first has the line; from then on it
    /// is ours.
    fn is_alone(&mut self) -> bool {
        true
    }

    /// Lets time pass without taking any byte from the line.
    fn rest(&mut self, time: Duration) {
        thread::sleep(time);
    }

    /// Ends what was recorded on the way.
    ///
    /// # Errors
    /// What was recorded can't be written.
    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}
