//! A link to a board through another Stepwright program that holds its port.
//!
//! ```text
//!   status, position, retarget, watch ──► local socket ──► move, run … ──► port
//! ```
//!
//! The socket carries lines and their answers, as the port does. An empty line stands for an answer that did
//! not come, so each line has exactly one answer.

use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::Link;
use super::door::Door;

/// How long an answer is waited for. The holder answers between two of its own lines, but not while it gives an
/// order.
pub const PATIENCE: Duration = Duration::from_secs(5);
/// The same for a caller that has to stop a motor: the holder may be suspended.
pub const SOON: Duration = Duration::from_secs(1);

/// A link through the program that holds the port.
pub struct GuestLink {
    stream: UnixStream,
    path: PathBuf,
    opened: Instant,
    /// The number of answers still to come.
    owed: usize,
    /// How long missing answers are waited for.
    patience: Duration,
}

impl GuestLink {
    /// Opens the link to the board on this port; `None` if no program that holds the port lets others in.
    pub fn open(port: &Path, patience: Duration) -> Option<GuestLink> {
        let stream = connect(port, patience).ok()?;
        Some(GuestLink { stream, path: port.to_owned(), opened: Instant::now(), owed: 0, patience })
    }

    /// Reads bytes into `buffer`, and returns their number.
    fn take(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        self.stream.set_read_timeout(Some(limit.max(Duration::from_millis(1))))?;
        match self.stream.read(buffer) {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(count) => {
                let ends = buffer.iter().take(count).filter(|byte| **byte == b'\r').count();
                self.owed = self.owed.saturating_sub(ends);
                Ok(count)
            }
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock => Ok(0),
                _ => Err(error),
            },
        }
    }
}

fn connect(port: &Path, patience: Duration) -> io::Result<UnixStream> {
    let door = Door::find(port).ok_or(ErrorKind::NotFound)?;
    let stream = UnixStream::connect(door.socket())?;
    stream.set_write_timeout(Some(patience))?;
    Ok(stream)
}

impl Link for GuestLink {
    /// First waits for missing answers: they belong to earlier lines. If they don't come, connects again: the
    /// holder does not say the lines of a connection that is closed.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let end = Instant::now() + self.patience;
        while self.owed > 0 {
            if Instant::now() >= end {
                (self.stream, self.owed) = (connect(&self.path, self.patience)?, 0);
                return Err(ErrorKind::TimedOut.into());
            }
            self.take(&mut [0; 256], Duration::from_millis(100))?;
        }
        self.owed = bytes.iter().filter(|byte| **byte == b'\r').count();
        self.stream.write_all(bytes)
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        self.take(buffer, limit)
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn name(&self) -> String {
        self.path.display().to_string()
    }
}
