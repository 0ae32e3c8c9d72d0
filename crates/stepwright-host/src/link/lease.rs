//! The lease of who holds a port, written down for who comes next.
//!
//! ```text
//!   holder:  note ──► L2000, the board's Y … L0, its Y ──► strike
//!              ╳ it dies
//!   next:    opens the port, finds the note ──► silent for 2 s: the board brakes ──► strike
//! ```
//!
//! A board can't tell who says a line, so to it every line is a sign of life of the holder. Who
//! finds the port free and a note beside it comes after a holder that has died: a question would
//! hold the dead one's lease. Nobody but a stop says a line before that lease has run out.

use std::cell::Cell;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use stepwright_protocol::{Command, LeaseMillis, Reply};

use super::door::Door;
use super::serial::LeaseWait;
use crate::session::Session;

/// Between two looks whether the waiting is to end.
const SLICE: Duration = Duration::from_millis(20);

/// The time of a note is no older than this beside the holder's last line.
const FRESH: Duration = Duration::from_millis(250);

/// Where a lease is written down. The time of the file is that of its holder's last line.
pub struct LeaseNote {
    path: PathBuf,
    /// When the file was given its time; `None` without a lease.
    told: Cell<Option<Instant>>,
}

impl LeaseNote {
    /// The note of the port with this door.
    pub fn of(door: &Door) -> LeaseNote {
        LeaseNote { path: door.lease(), told: Cell::new(None) }
    }

    /// A line is about to be said: one that asks for a lease is written down before the board
    /// hears of it.
    pub fn before(&self, line: Command) {
        match line {
            // Where it can't be written the board brakes all the same, unless others ask it.
            Command::Lease(lease) if lease != LeaseMillis::SMALLEST => {
                let _ = fs::write(&self.path, lease.get().to_string());
                self.told.set(Some(Instant::now()));
            }
            _ => {}
        }
    }

    /// A line was answered: the lease is held, or the board has it back.
    pub fn after(&self, line: Command, answer: Reply) {
        if (line, answer) == (Command::Lease(LeaseMillis::SMALLEST), Reply::Yes) {
            self.told.set(None);
            return self.strike();
        }
        if self.told.get().is_some_and(|told| told.elapsed() >= FRESH) {
            self.told.set(Some(Instant::now()));
            let file = File::options().write(true).open(&self.path);
            let _ = file.and_then(|file| file.set_modified(SystemTime::now()));
        }
    }

    fn strike(&self) {
        let _ = fs::remove_file(&self.path);
    }

    /// The lease that stands there, and how long ago its holder has said a line.
    fn read(&self) -> Option<(LeaseMillis, Duration)> {
        let lease = LeaseMillis::new(fs::read_to_string(&self.path).ok()?.parse().ok()?)?;
        let held = fs::metadata(&self.path).and_then(|about| about.modified()).ok()?;
        // A time to come is no age.
        Some((lease, held.elapsed().unwrap_or_default()))
    }
}

/// Is silent until the lease has run out that a dead holder of this port has left; the port is
/// ours, so nobody else speaks meanwhile. `tell` hears of a lease that is waited for, and
/// `is_over` is asked whether the waiting is to end before.
pub fn let_run_out(
    port: &Path,
    tell: impl FnOnce(LeaseMillis),
    is_over: impl Fn() -> bool,
) -> LeaseWait {
    let Some(note) = Door::find(port).map(|door| LeaseNote::of(&door)) else {
        return LeaseWait::Over;
    };
    let Some((lease, age)) = note.read() else { return LeaseWait::Over };
    let millis = u64::from(lease.get());
    // The board's clock may be slower, and its last answer took its time.
    let lasts = Duration::from_millis(millis + millis / 50 + 100) + FRESH;
    let left = lasts.saturating_sub(age);
    if !left.is_zero() {
        tell(lease);
    }
    let end = Instant::now() + left;
    while Instant::now() < end {
        if is_over() {
            return LeaseWait::Ended;
        }
        thread::sleep(SLICE);
    }
    note.strike();
    LeaseWait::Over
}

/// Gives a lease back that a dead holder of this port has left, once everything rests.
pub fn give_back(port: &Path, session: &mut Session) {
    let note = Door::find(port).map(|door| LeaseNote::of(&door));
    if let Some(note) = note.filter(|note| note.read().is_some())
        && let Ok(Reply::Yes) = session.ask(Command::Lease(LeaseMillis::SMALLEST))
    {
        note.strike();
    }
}
