//! The link to a board: a serial port, a socket, a virtual board in this process, or another program that holds
//! the port.
//!
//! All links carry bytes and nothing else: a virtual board gets the same bytes as a board on a real line.

#[cfg(feature = "virtual")]
pub mod bench;
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

/// Why a link could not be opened.
#[derive(Debug)]
pub enum OpenError {
    /// Another program has the port.
    InUse,
    /// The wait for a dead holder's lease was interrupted.
    Ended,
    /// The system refused to open the port.
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

/// A link to a board, with the clock for its timeouts.
pub trait Link {
    /// Writes bytes to the line.
    ///
    /// # Errors
    /// The line is gone, or it takes no byte for a while ([`io::ErrorKind::TimedOut`]).
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Waits for bytes, at most `limit`. Returns the number of bytes; 0 if none came in that time.
    ///
    /// # Errors
    /// The line is gone.
    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize>;

    /// The time since the link was opened; by the board's own clock if it is simulated.
    fn now(&self) -> Duration;

    /// The name of the board in a sentence: `the virtual board`.
    fn name(&self) -> String;

    /// Whether no other program that respects the port's lock has the line. If so, this program has it from
    /// then on.
    fn is_alone(&mut self) -> bool {
        true
    }

    /// Lets time pass without reading from the line.
    fn rest(&mut self, time: Duration) {
        thread::sleep(time);
    }

    /// Ends a recording of the line.
    ///
    /// # Errors
    /// The recording can't be written.
    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}
