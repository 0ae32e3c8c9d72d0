//! Lets other Stepwright programs ask the board whose port this program holds.
//!
//! Each guest has a thread that reads its lines. The conversation with the board stays with the holder of the
//! port, which says a guest's line when it has nothing to say itself, and only while the guest is connected: a
//! guest that gives its line up closes the connection. Each guest has a selection of its own: an `A` of one
//! guest does not affect the others.

use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use stepwright_protocol::{Command, Reply, Selection, crc};

use super::door::Door;
use super::lease::LeaseNote;
use crate::guests::{GuestLine, Guests, is_allowed, parsed};

/// The most bytes of a line, with its checksum and CR.
const LONGEST: u64 = 64;

/// The time between two attempts to take a guest that can't be taken.
const RETRY: Duration = Duration::from_millis(100);

/// The door for guests; it closes when it is dropped.
pub struct Host {
    socket: PathBuf,
    asked: Receiver<(GuestLine, UnixStream)>,
    /// This program's lease, noted for the next holder.
    lease: LeaseNote,
    /// Whether the door is closed.
    closed: Arc<AtomicBool>,
}

impl Host {
    /// Opens the door of a port that this program holds alone. `None` where there can't be a door: other
    /// programs then find the port in use.
    pub fn open(port: &Path) -> Option<Host> {
        let door = Door::make(port)?;
        let (socket, lease) = (door.socket(), LeaseNote::of(&door));
        // A socket that a dead holder left behind: the port is ours.
        let _ = fs::remove_file(&socket);
        let listener = UnixListener::bind(&socket).ok()?;
        let (ask, asked) = mpsc::channel();
        let closed = Arc::new(AtomicBool::new(false));
        let over = closed.clone();
        thread::spawn(move || admit(listener.incoming(), &over, &ask));
        Some(Host { socket, asked, lease, closed })
    }
}

impl Guests for Host {
    fn next(&mut self) -> Option<GuestLine> {
        let connected = self.asked.try_iter().find(|(_, guest)| !has_hung_up(guest))?;
        Some(connected.0)
    }

    fn before(&self, command: Command) {
        self.lease.before(command);
    }

    fn after(&self, command: Command, reply: Reply) {
        self.lease.after(command, reply);
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        self.closed.store(true, Ordering::SeqCst);
        // The listening thread ends at its next connection; otherwise it and its socket would stay.
        let _ = UnixStream::connect(&self.socket);
        let _ = fs::remove_file(&self.socket);
    }
}

/// Serves guests until the door is closed.
fn admit(
    guests: impl Iterator<Item = io::Result<UnixStream>>,
    closed: &AtomicBool,
    ask: &Sender<(GuestLine, UnixStream)>,
) {
    for guest in guests {
        if closed.load(Ordering::SeqCst) {
            break;
        }
        let Ok(guest) = guest else {
            // Out of descriptors, which would be said again at once.
            thread::sleep(RETRY);
            continue;
        };
        let ask = ask.clone();
        thread::spawn(move || serve(guest, &ask));
    }
}

/// Whether the other end of a connection is closed.
fn has_hung_up(guest: &UnixStream) -> bool {
    // HUP is always reported.
    let mut polled = [PollFd::new(guest, PollFlags::empty())];
    poll(&mut polled, Some(&Timespec::default())).is_ok()
        && polled.iter().any(|guest| guest.revents().contains(PollFlags::HUP))
}

/// Reads the lines of a guest and writes the answers, until either side is gone.
fn serve(mut guest: UnixStream, ask: &Sender<(GuestLine, UnixStream)>) -> Option<()> {
    let mut lines = BufReader::new(guest.try_clone().ok()?);
    let mut selection = Selection::FIRST;
    loop {
        let mut line = Vec::new();
        lines.by_ref().take(LONGEST).read_until(b'\r', &mut line).ok()?;
        // The end, or a line that is too long.
        line.pop().filter(|last| *last == b'\r')?;
        let (answer, answered) = mpsc::channel();
        let command = parsed(&line);
        let line = if is_allowed(&line) { line } else { refused(&line) };
        ask.send((GuestLine { line, selection, answer }, guest.try_clone().ok()?)).ok()?;
        let answer = answered.recv().ok()?.unwrap_or_default();
        if let (Some(Command::Select(axes)), true) = (command, answer.starts_with('Y')) {
            selection = axes;
        }
        guest.write_all(format!("{answer}\r").as_bytes()).ok()?;
    }
}

/// The replacement of a line that a guest may not say: not a line of the protocol, with a checksum if the guest
/// expects one in the answer.
fn refused(line: &[u8]) -> Vec<u8> {
    const NONE: &[u8] = b"#";
    let sum = NONE.iter().fold(0, |sum, byte| crc(sum, *byte));
    if line.contains(&b'*') { format!("#*{sum:02X}").into_bytes() } else { NONE.to_vec() }
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind;
    use std::time::Instant;

    use super::*;

    /// A guest that can't be taken is tried again a few times a second, not without a pause.
    #[test]
    fn a_guest_that_cannot_be_taken_costs_no_time_of_the_processor() {
        let begun = Instant::now();
        let guests = (0..3).map(|_| Err(ErrorKind::OutOfMemory.into()));
        admit(guests, &AtomicBool::new(false), &mpsc::channel().0);
        assert!(begun.elapsed() >= 3 * RETRY);
    }

    #[test]
    fn a_line_is_refused_as_it_was_said() {
        assert_eq!(refused(b"PO"), b"#");
        // 0x07 times '#' in GF(2^8), by hand: 0x23 << 8 modulo x^8 + x^2 + x + 1.
        assert_eq!(refused(b"PO*12"), b"#*E9");
    }

    #[test]
    fn a_guest_gives_no_orders() {
        let asks = ["F", "V1", "?", "A2*3F", "!", "$", "$pulse-us", "@"];
        let changes = ["t400", "m500500", "a10", "d10", "j0", "Z", "K", "@-5", "m500500*3F"];
        for line in asks.into_iter().chain(changes) {
            assert!(is_allowed(line.as_bytes()), "{line}");
        }
        let none = ["PO", "P0", "S5", "T100", "R9", "G+4", "g+", "E", "I1", "L500", "s5", "#", ""];
        let none = none.into_iter().chain(["$pulse-us=3", "$reset", "$reset*00", "A9", "@*00"]);
        for line in none {
            assert!(!is_allowed(line.as_bytes()), "{line}");
        }
    }
}
