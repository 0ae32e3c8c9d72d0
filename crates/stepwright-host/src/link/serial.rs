//! A serial port.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use serial2::SerialPort;

use super::{Link, OpenError};

/// How long a port may take no byte before it counts as stuck.
const WRITE_LIMIT: Duration = Duration::from_millis(500);

/// How long to wait for a program that only asks a question and then frees the port.
const TURN: Duration = Duration::from_millis(500);

/// How long a board may be silent before DTR is raised, on a system that opens ports with DTR low.
const CALL: Duration = Duration::from_millis(300);

/// How a port is shared with other programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Share {
    /// Not with other programs that respect the port's lock (this library, pyserial's `exclusive`): two hosts
    /// would take each other's answers.
    Alone,
    /// As `Alone`, but other programs may ask the board through this one.
    Host,
    /// As `Alone`, or else through the program that has the port.
    Guest,
    /// Opened in any case: a stop must get through.
    Anyhow,
}

/// How the wait for a dead holder's lease ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeaseWait {
    /// There is no lease, or it has run out: lines may be said on the port.
    Over,
    /// The wait was ended early: the port is given up.
    Ended,
}

/// An open serial port: 8N1, raw.
pub struct SerialLink {
    port: SerialPort,
    path: PathBuf,
    opened: Instant,
    /// Whether the board was heard, or DTR is high.
    called: bool,
}

impl SerialLink {
    /// Opens a port. Once the port is ours, `lease` waits for the lease of a dead holder to run out, as
    /// `link::lease::let_run_out` does. A board whose program knows no leases needs no wait.
    ///
    /// # Errors
    /// [`OpenError`]
    pub fn open(
        path: &Path,
        baud: u32,
        share: Share,
        lease: impl FnOnce(&Path) -> LeaseWait,
    ) -> Result<SerialLink, OpenError> {
        let mut port = open(path, baud)?;
        keep_dtr(&port);
        let alone = share != Share::Anyhow;
        if alone && !becomes_ours(&port) {
            return Err(OpenError::InUse);
        }
        if alone && lease(path) == LeaseWait::Ended {
            return Err(OpenError::Ended);
        }
        // Earlier bytes are not for us. If the port is shared they may be for another program. An error would
        // show later.
        if alone {
            let _ = port.discard_buffers();
        }
        let _ = port.set_write_timeout(WRITE_LIMIT);
        let (path, opened) = (path.to_owned(), Instant::now());
        Ok(SerialLink { port, path, opened, called: !cfg!(windows) })
    }
}

impl SerialLink {
    /// Resets the board, if its port can: most boards reset when DTR rises.
    pub fn reset(&mut self) {
        // A port without modem lines can't reset the board.
        let _ = self.port.set_dtr(false).and_then(|()| self.port.set_rts(false));
        thread::sleep(Duration::from_millis(250));
        let _ = self.port.set_dtr(true).and_then(|()| self.port.set_rts(true));
        // Time for the boot loader to begin.
        thread::sleep(Duration::from_millis(50));
        let _ = self.port.discard_buffers();
        self.called = true;
    }

    /// Raises DTR if the board is silent. On Windows a port is opened with DTR low. So no Arduino is reset, and
    /// its position stays known; but a Pico takes its USB port as closed, and does not answer.
    fn call(&mut self) {
        if !self.called && self.opened.elapsed() >= CALL {
            self.called = true;
            // A port without modem lines needs no call.
            let _ = self.port.set_dtr(true).and_then(|()| self.port.set_rts(true));
        }
    }
}

/// Opens a port. On Windows an open port is exclusive, so this waits for a program that only asks a question.
fn open(path: &Path, baud: u32) -> Result<SerialPort, OpenError> {
    let begin = Instant::now();
    loop {
        match SerialPort::open(path, baud) {
            Err(error) if cfg!(windows) && error.kind() == ErrorKind::PermissionDenied => {
                if begin.elapsed() >= TURN {
                    return Err(OpenError::InUse);
                }
                thread::sleep(Duration::from_millis(20));
            }
            opened => return opened.map_err(OpenError::Io),
        }
    }
}

/// Keeps DTR high when the port is closed. Many boards reset when DTR rises, so otherwise each command would
/// find the board at position 0.
#[cfg(unix)]
fn keep_dtr(port: &SerialPort) {
    use rustix::termios::{ControlModes, OptionalActions, tcgetattr, tcsetattr};
    // A port without modem lines can't, and need not.
    if let Ok(mut settings) = tcgetattr(port) {
        settings.control_modes.remove(ControlModes::HUPCL);
        let _ = tcsetattr(port, OptionalActions::Now, &settings);
    }
}

#[cfg(not(unix))]
fn keep_dtr(_: &SerialPort) {}

/// Locks the port; true if another program has the lock.
#[cfg(unix)]
fn is_taken(port: &SerialPort) -> bool {
    use rustix::fs::{FlockOperation, flock};
    flock(port, FlockOperation::NonBlockingLockExclusive) == Err(rustix::io::Errno::WOULDBLOCK)
}

/// Waits for the lock of the port; false if another program keeps it.
fn becomes_ours(port: &SerialPort) -> bool {
    let begin = Instant::now();
    while is_taken(port) {
        if begin.elapsed() >= TURN {
            return false;
        }
        thread::sleep(Duration::from_millis(20));
    }
    true
}

/// An open port is exclusive.
#[cfg(not(unix))]
fn is_taken(_: &SerialPort) -> bool {
    false
}

impl Link for SerialLink {
    fn write(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        let begun = Instant::now();
        while !bytes.is_empty() {
            match self.port.write(bytes) {
                Ok(0) => return Err(ErrorKind::BrokenPipe.into()),
                Ok(count) => bytes = bytes.get(count..).unwrap_or_default(),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                // The buffer is full with bytes of another program: a stop does not wait for its lock.
                Err(error)
                    if error.kind() == ErrorKind::WouldBlock && begun.elapsed() < WRITE_LIMIT =>
                {
                    thread::sleep(Duration::from_millis(1));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        let limit = if self.called { limit } else { limit.min(CALL) };
        self.port.set_read_timeout(limit.max(Duration::from_millis(1)))?;
        match self.port.read(buffer) {
            // A port that is readable without a byte has been unplugged.
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(count) => {
                self.called = true;
                Ok(count)
            }
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock => {
                    self.call();
                    Ok(0)
                }
                _ => Err(error),
            },
        }
    }

    fn is_alone(&mut self) -> bool {
        !is_taken(&self.port)
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn name(&self) -> String {
        self.path.display().to_string()
    }
}
