//! A pseudo-terminal, which serial programs open like a port.
//!
//! Programs come and go. While none has it open, reading fails (`EIO`), and the board's output is
//! lost, as on a cable without a listener.

use std::io;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, tcflush, tcgetattr, tcsetattr};

/// The board's end of a pseudo-terminal.
#[derive(Debug)]
pub struct Pty {
    master: OwnedFd,
    path: PathBuf,
    /// Whether a program had it open at the last check.
    visited: bool,
}

impl Pty {
    /// Opens a new one.
    ///
    /// # Errors
    /// The system has none, or denies it.
    pub fn open() -> io::Result<Pty> {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let flags = rustix::fs::fcntl_getfl(&master)?;
        rustix::fs::fcntl_setfl(&master, flags | OFlags::NONBLOCK)?;
        let name = ptsname(&master, Vec::new())?;
        let path = PathBuf::from(name.to_string_lossy().into_owned());
        let pty = Pty { master, path, visited: false };
        pty.freshen();
        Ok(pty)
    }

    /// The path for a program to open.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Sets up the line for the next program: raw, so that answers don't come back as an echo, and
    /// without old answers.
    fn freshen(&self) {
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        // If it fails, the next program finds the line as the last one left it.
        let Ok(end) = rustix::fs::open(&self.path, flags, Mode::empty()) else { return };
        let _ = tcflush(&end, QueueSelector::IFlush);
        if let Ok(mut settings) = tcgetattr(&end) {
            settings.make_raw();
            let _ = tcsetattr(&end, OptionalActions::Now, &settings);
        }
    }

    /// The bytes received since the last call; does not wait.
    ///
    /// # Errors
    /// The pseudo-terminal is broken.
    pub fn read(&mut self) -> io::Result<Vec<u8>> {
        let mut buffer = [0; 1024];
        match rustix::io::read(&self.master, &mut buffer) {
            Ok(0) | Err(Errno::IO) => {
                if std::mem::take(&mut self.visited) {
                    self.freshen();
                }
                Ok(Vec::new())
            }
            Ok(count) => {
                self.visited = true;
                Ok(buffer[..count].to_vec())
            }
            Err(Errno::AGAIN | Errno::INTR) => {
                self.visited = true;
                Ok(Vec::new())
            }
            Err(error) => Err(error.into()),
        }
    }

    /// Writes `bytes`; bytes that the line does not accept are lost.
    pub fn write(&mut self, bytes: &[u8]) {
        if self.visited && !bytes.is_empty() {
            let _ = rustix::io::write(&self.master, bytes);
        }
    }
}
