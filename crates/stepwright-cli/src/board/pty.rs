//! The board's line on a pseudo-terminal.
//!
//! ```text
//!   a serial program ──open──► /dev/pts/N ══ the kernel ══ master ──► the board
//! ```
//!
//! Programs come and go. While none has the path open, reading from the master
//! fails (`EIO`): the board then looks again every few milliseconds. As on a
//! cable, what it says meanwhile is lost, and so is what nobody reads for long.

use std::io::{self, Write};
use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{
    LocalModes, OptionalActions, OutputModes, QueueSelector, Termios, tcflush, tcgetattr, tcsetattr,
};

use super::bench::Bench;
use crate::failure::Failure;
use crate::{interrupt, say};
use stepwright_host::link::pace::Paced;
use stepwright_host::link::simulated::Simulated;

/// How soon a program that opens the path is noticed, and Ctrl-C.
const SLICE: Duration = Duration::from_millis(10);

/// Answers that wait for a reader, in bytes; beyond, they are lost.
const WAITING: usize = 64 * 1024;

/// Serves whoever opens the path, until Ctrl-C.
pub fn serve(board: &mut Paced<Bench>) -> Result<(), Failure> {
    let mut pty = Pty::open().map_err(failed)?;
    let mut out = io::stdout().lock();
    // A program that waits for the path and then closes its end is no reason
    // to stop serving it.
    let _ = writeln!(out, "pty {}", pty.path.display()).and_then(|()| out.flush());
    drop(out);
    say::note(format_args!(
        "try it from another terminal: stepwright move 4000 --port {}; Ctrl-C ends the board",
        pty.path.display()
    ));
    let mut waiting: Vec<u8> = Vec::new();
    while !interrupt::asked() {
        let hurry = board.is_fast() && board.board.is_busy();
        let seen = pty.wait(!waiting.is_empty(), hurry).map_err(failed)?;
        board.catch_up();
        for byte in seen.bytes {
            board.receive(byte);
        }
        waiting.extend(board.board.take_answers());
        waiting.truncate(WAITING);
        if hurry {
            board.pass(SLICE);
        }
        if seen.nobody {
            waiting.clear();
            if !hurry {
                thread::sleep(SLICE);
            }
        } else {
            let sent = pty.write(&waiting).map_err(failed)?;
            waiting.drain(..sent);
        }
    }
    Ok(())
}

fn failed(error: Errno) -> Failure {
    Failure::new(format!("the pseudo-terminal fails: {}", io::Error::from(error)))
        .hint("`stepwright board --stdio` needs none")
}

/// What a look at the line shows.
struct Seen {
    bytes: Vec<u8>,
    /// No program has the path open.
    nobody: bool,
}

/// The master's end of a pseudo-terminal.
struct Pty {
    master: OwnedFd,
    path: PathBuf,
    /// Whether a program has come since the last one left.
    visited: bool,
}

impl Pty {
    fn open() -> Result<Pty, Errno> {
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

    /// Makes the line as the next program should find it: raw, so that our
    /// answers don't come back to us as an echo, and without old answers.
    fn freshen(&mut self) {
        self.visited = false;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        // If it fails, the next program finds the line as the last one left it.
        let Ok(slave) = rustix::fs::open(&self.path, flags, Mode::empty()) else { return };
        let _ = tcflush(&slave, QueueSelector::IFlush);
        if let Ok(mut settings) = tcgetattr(&slave)
            && is_cooked(&settings)
        {
            settings.make_raw();
            let _ = tcsetattr(&slave, OptionalActions::Now, &settings);
        }
    }

    /// Waits a little until something comes, not at all if `hurry`.
    fn wait(&mut self, to_write: bool, hurry: bool) -> Result<Seen, Errno> {
        let mut events = PollFlags::IN;
        if to_write {
            events |= PollFlags::OUT;
        }
        let nanos = if hurry { 0 } else { SLICE.as_nanos() as i64 };
        let limit = Timespec { tv_sec: 0, tv_nsec: nanos as _ };
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

    /// Says as much as the line takes now.
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Errno> {
        if bytes.is_empty() {
            return Ok(0);
        }
        match rustix::io::write(&self.master, bytes) {
            Ok(count) => Ok(count),
            // Nobody reads; or they have just left, which the next look shows.
            Err(Errno::AGAIN | Errno::INTR | Errno::IO) => Ok(0),
            Err(error) => Err(error),
        }
    }
}

/// Whether the line changes what passes through it.
fn is_cooked(settings: &Termios) -> bool {
    let echoes = LocalModes::ECHO | LocalModes::ICANON | LocalModes::ISIG;
    settings.local_modes.intersects(echoes)
        || settings.output_modes.contains(OutputModes::OPOST)
        || settings.input_modes.contains(rustix::termios::InputModes::ICRNL)
}
