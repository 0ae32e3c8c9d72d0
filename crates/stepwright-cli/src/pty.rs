//! A pseudo-terminal: a serial port for other programs.
//!
//! ```text
//!   a serial program ──open──► /dev/pts/N ══ the kernel ══ master ──► what we are
//! ```
//!
//! Programs may open and close it at any time. While none has the path open, reading from the
//! master fails (`EIO`); the server then tries again every few milliseconds.

use std::io;
use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{
    LocalModes, OptionalActions, OutputModes, QueueSelector, Termios, tcflush, tcgetattr, tcsetattr,
};

use crate::failure::Failure;

/// The interval of the checks for a program that opens the path, and for Ctrl-C.
pub const SLICE: Duration = Duration::from_millis(10);

/// The failure for an error of a pseudo-terminal.
pub fn failed(error: Errno) -> Failure {
    Failure::new(format!("the pseudo-terminal fails: {}", io::Error::from(error)))
        .hint("`--stdio` needs none")
}

/// The result of a wait for input.
pub struct Seen {
    /// The bytes that were received.
    pub bytes: Vec<u8>,
    /// Whether no program has the path open.
    pub nobody: bool,
}

/// The master's end of a pseudo-terminal.
pub struct Pty {
    master: OwnedFd,
    /// The path that other programs open.
    pub path: PathBuf,
    /// Whether a program has opened the path since the last one closed it.
    visited: bool,
}

impl Pty {
    /// Opens a pseudo-terminal.
    pub fn open() -> Result<Pty, Errno> {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        rustix::io::fcntl_setfd(&master, rustix::io::FdFlags::CLOEXEC)?;
        grantpt(&master)?;
        unlockpt(&master)?;
        let flags = rustix::fs::fcntl_getfl(&master)?;
        rustix::fs::fcntl_setfl(&master, flags | OFlags::NONBLOCK)?;
        let name = ptsname(&master, Vec::new())?;
        let path = PathBuf::from(name.to_string_lossy().into_owned());
        let mut pty = Pty { master, path, visited: true };
        pty.freshen();
        Ok(pty)
    }

    /// Prepares the line for the next program: raw, so that the answers are not echoed back, and
    /// without old answers.
    fn freshen(&mut self) {
        self.visited = false;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        // If this fails, the next program finds the line as the last one left it.
        let Ok(slave) = rustix::fs::open(&self.path, flags, Mode::empty()) else { return };
        let _ = tcflush(&slave, QueueSelector::IFlush);
        if let Ok(mut settings) = tcgetattr(&slave)
            && is_cooked(&settings)
        {
            settings.make_raw();
            let _ = tcsetattr(&slave, OptionalActions::Now, &settings);
        }
    }

    /// Waits until there is input, for at most this long.
    pub fn wait(&mut self, to_write: bool, most: Duration) -> Result<Seen, Errno> {
        let mut events = PollFlags::IN;
        if to_write {
            events |= PollFlags::OUT;
        }
        let limit = Timespec { tv_sec: 0, tv_nsec: most.subsec_nanos() as _ };
        let mut fds = [PollFd::new(&self.master, events)];
        match poll(&mut fds, Some(&limit)) {
            Ok(_) | Err(Errno::INTR) => {}
            Err(error) => return Err(error),
        }
        let mut buffer = [0; 1024];
        match rustix::io::read(&self.master, &mut buffer) {
            Ok(0) | Err(Errno::IO) => {
                if self.visited {
                    self.freshen();
                }
                Ok(Seen { bytes: Vec::new(), nobody: true })
            }
            Ok(count) => {
                self.visited = true;
                let bytes = buffer.iter().take(count).copied().collect();
                Ok(Seen { bytes, nobody: false })
            }
            Err(Errno::AGAIN | Errno::INTR) => {
                self.visited = true;
                Ok(Seen { bytes: Vec::new(), nobody: false })
            }
            Err(error) => Err(error),
        }
    }

    /// Writes as many bytes as the line takes now. Returns their number.
    pub fn write(&mut self, bytes: &[u8]) -> Result<usize, Errno> {
        if bytes.is_empty() {
            return Ok(0);
        }
        match rustix::io::write(&self.master, bytes) {
            Ok(count) => Ok(count),
            // Nobody reads, or the reader has just closed the path, which the next wait shows.
            Err(Errno::AGAIN | Errno::INTR | Errno::IO) => Ok(0),
            Err(error) => Err(error),
        }
    }
}

/// Whether the line discipline changes the bytes that pass.
fn is_cooked(settings: &Termios) -> bool {
    let echoes = LocalModes::ECHO | LocalModes::ICANON | LocalModes::ISIG;
    settings.local_modes.intersects(echoes)
        || settings.output_modes.contains(OutputModes::OPOST)
        || settings.input_modes.contains(rustix::termios::InputModes::ICRNL)
}
