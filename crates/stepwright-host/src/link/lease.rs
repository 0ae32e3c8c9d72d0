//! The lease of a port's holder, noted for the next holder.
//!
//! ```text
//!   holder:  note ──► L2000, the board's Y … L0, its Y ──► strike
//!              ╳ it dies
//!   next:    opens the port, finds the note ──► silent for 2 s: the board brakes ──► strike
//! ```
//!
//! A board can't tell who says a line, so every line renews the holder's lease. If a program gets the port and
//! finds a note, the last holder has died, and any question would renew the dead holder's lease. So only a stop
//! says a line before that lease has run out.

use std::cell::Cell;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use stepwright_protocol::{Command, LeaseMillis, Reply};

use super::door::Door;
use super::serial::LeaseWait;
use crate::session::Session;

/// The time between two checks whether the wait is to end.
const SLICE: Duration = Duration::from_millis(20);

/// The time of a note is at most this much older than the holder's last line.
const FRESH: Duration = Duration::from_millis(250);

/// The file with a holder's lease. Its modification time is that of the holder's last line.
pub struct LeaseNote {
    path: PathBuf,
    /// When the file last got its time; `None` without a lease.
    told: Cell<Option<Instant>>,
}

impl LeaseNote {
    /// The note for the port of this door.
    pub fn of(door: &Door) -> LeaseNote {
        LeaseNote { path: door.lease(), told: Cell::new(None) }
    }

    /// Called before a line is said. Notes a lease before the board hears of it.
    pub fn before(&self, line: Command) {
        match line {
            // If the note can't be written the board brakes all the same, unless other programs ask it.
            Command::Lease(lease) if lease != LeaseMillis::SMALLEST => {
                let _ = fs::write(&self.path, lease.get().to_string());
                self.told.set(Some(Instant::now()));
            }
            _ => {}
        }
    }

    /// Called when a line was answered. Renews the note, or removes it if the lease was given back.
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

    /// The noted lease, and how long ago its holder last said a line.
    fn read(&self) -> Option<(LeaseMillis, Duration)> {
        let lease = LeaseMillis::new(fs::read_to_string(&self.path).ok()?.parse().ok()?)?;
        let held = fs::metadata(&self.path).and_then(|about| about.modified()).ok()?;
        // A time in the future counts as age 0.
        Some((lease, held.elapsed().unwrap_or_default()))
    }
}

/// Waits silently until the lease of a dead holder of this port has run out. The port is ours, so no other
/// program says a line meanwhile. `tell` is called with the lease if there is one to wait for; `is_over`
/// returns whether to end the wait early.
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
    // A margin for a slower clock of the board, and for the time of its last answer.
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

/// Gives back the lease of a dead holder of this port, once everything rests.
pub fn give_back(port: &Path, session: &mut Session) {
    let note = Door::find(port).map(|door| LeaseNote::of(&door));
    if let Some(note) = note.filter(|note| note.read().is_some())
        && let Ok(Reply::Yes) = session.ask(Command::Lease(LeaseMillis::SMALLEST))
    {
        note.strike();
    }
}
