//! A serial port.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use serial2::SerialPort;

use super::{Link, OpenError};

/// A port that takes no byte for this time is stuck.
const WRITE_LIMIT: Duration = Duration::from_millis(500);

/// A program that only asks a question has the port for this time.
const TURN: Duration = Duration::from_millis(500);

/// Whether others may use the port meanwhile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Share {
    /// No other program that asks before opening (this library, pyserial's `exclusive`): two
    /// masters would take each other's answers.
    Alone,
    /// The same, and others may ask the board through this program.
    Host,
    /// Alone, or else through the program that has the port.
    Guest,
    /// Regardless of them: a stop must get through.
    Anyhow,
}

/// How the waiting for the lease of a dead holder has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeaseWait {
    /// There is no lease, or it has run out: the port may be spoken on.
    Over,
    /// It was ended before: the port is given up.
    Ended,
}

/// An open serial port: 8N1, raw.
pub struct SerialLink {
    port: SerialPort,
    path: PathBuf,
    opened: Instant,
}

impl SerialLink {
    /// Opens a port. `lease` lets a lease run out that a dead holder of it has left, once the
    /// port is ours: `link::lease::let_run_out` does, and a board that
    /// plays no leases has none.
    ///
    /// # Errors
    /// [`OpenError`]
    pub fn open(
        path: &Path,
        baud: u32,
        share: Share,
        lease: impl FnOnce(&Path) -> LeaseWait,
    ) -> Result<SerialLink, OpenError> {
        let mut port = SerialPort::open(path, baud).map_err(OpenError::Io)?;
        keep_dtr(&port);
        let alone = share != Share::Anyhow;
        if alone && !becomes_ours(&port) {
            return Err(OpenError::InUse);
        }
        if alone && lease(path) == LeaseWait::Ended {
            return Err(OpenError::Ended);
        }
        // What came before we opened is not for us, unless it is for another
        // who is still listening; an error shows later.
        if alone {
            let _ = port.discard_buffers();
        }
        let _ = port.set_write_timeout(WRITE_LIMIT);
        Ok(SerialLink { port, path: path.to_owned(), opened: Instant::now() })
    }
}

impl SerialLink {
    /// Resets the board, as far as its port can: most do so when DTR rises.
    pub fn reset(&mut self) {
        // A port without modem lines can't.
        let _ = self.port.set_dtr(false).and_then(|()| self.port.set_rts(false));
        thread::sleep(Duration::from_millis(250));
        let _ = self.port.set_dtr(true).and_then(|()| self.port.set_rts(true));
        // The boot loader begins.
        thread::sleep(Duration::from_millis(50));
        let _ = self.port.discard_buffers();
    }
}

/// Leaves DTR up when the port is closed. Many boards reset when it rises, so
/// that otherwise every command would find them at position 0.
#[cfg(unix)]
fn keep_dtr(port: &SerialPort) {
    use rustix::termios::{ControlModes, OptionalActions, tcgetattr, tcsetattr};
    // A port without modem lines can't; nor need it.
    if let Ok(mut settings) = tcgetattr(port) {
        settings.control_modes.remove(ControlModes::HUPCL);
        let _ = tcsetattr(port, OptionalActions::Now, &settings);
    }
}

#[cfg(not(unix))]
fn keep_dtr(_: &SerialPort) {}

/// Takes the port for ourselves; true if another program has.
#[cfg(unix)]
fn is_taken(port: &SerialPort) -> bool {
    use rustix::fs::{FlockOperation, flock};
    flock(port, FlockOperation::NonBlockingLockExclusive) == Err(rustix::io::Errno::WOULDBLOCK)
}

/// Waits until the port is ours; false if another program keeps it.
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

/// Elsewhere an open port is exclusive anyway.
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
                // Another program, which a stop does not wait for, has taken the room.
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
        self.port.set_read_timeout(limit.max(Duration::from_millis(1)))?;
        match self.port.read(buffer) {
            // A port that is readable without a byte has been unplugged.
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(count) => Ok(count),
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock => Ok(0),
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
