//! Guests: other programs that ask a board through the one that holds its line.

use std::sync::mpsc::Sender;

use stepwright_protocol::{AxisId, Command, Reply, Selection};

use crate::conversation::{Conversation, LinkError};

/// A line of a guest.
pub struct GuestLine {
    /// The line, without its CR.
    pub line: Vec<u8>,
    /// The guest's own selection, which is restored before the line.
    pub selection: Selection,
    /// Where the answer goes: unchanged, or `None` if there was none.
    pub answer: Sender<Option<String>>,
}

/// The guests of a line, and the lease note for the next holder of the port.
pub trait Guests: Send {
    /// The next line of a guest, if there is one.
    fn next(&mut self) -> Option<GuestLine>;

    /// Called before a line of this program is said.
    fn before(&self, command: Command);

    /// Called when a line of this program was answered.
    fn after(&self, command: Command, reply: Reply);
}

/// A guest's question to the program that holds the port: where the travel of the selected axis began.
const BEGAN: &[u8] = b"@";

/// The most changes that are kept for a holder of the port that does not ask for them.
const CHANGES: usize = 64;

/// What a line does, as far as guests are concerned.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Matter {
    /// It asks, selects or clears.
    Asks,
    /// It changes a travel, or ends it.
    Changes,
    /// It is reserved to the holder. An order has several lines, which would mix with the holder's own.
    Orders,
}

impl Matter {
    fn of(command: Command) -> Matter {
        use Command::*;
        match command {
            Status | Position(_) | Select(_) | Info | Clear | Settings | Setting(_) => Matter::Asks,
            Top(_) | Milli(_) | Accel(_) | Decel(_) | Jerk(_) | Retarget(_) => Matter::Changes,
            Stop | Kill => Matter::Changes,
            Program | StartTens(_) | TopTens(_) | Ramp(_) | Start(_) | Go(_) | Run(_) => {
                Matter::Orders
            }
            Execute | Zero(_) | Lease(_) | Set(_) | Reset => Matter::Orders,
        }
    }
}

/// Parses a line of a guest, without its checksum.
pub(crate) fn parsed(line: &[u8]) -> Option<Command> {
    Command::parse(line.split(|byte| *byte == b'*').next()?).ok()
}

/// Whether a guest may say this.
#[cfg(all(unix, feature = "serial"))]
pub(crate) fn is_allowed(line: &[u8]) -> bool {
    line == BEGAN || parsed(line).is_some_and(|command| Matter::of(command) != Matter::Orders)
}

impl Conversation {
    /// Where the travel of an axis began, if the program that holds the port knows.
    pub async fn began(&mut self, axis: AxisId) -> Result<Option<i64>, LinkError> {
        self.select(Selection::One(axis)).await?;
        let answer = self.say(BEGAN).await?;
        Ok(answer.and_then(|answer| answer.parse().ok()))
    }

    /// Says one line of a guest, if there is one; then it is the holder's turn again. Only the holder's own
    /// lines are meant to hold its lease, and many guests must not keep the holder from saying them.
    pub(crate) async fn serve_guest(&mut self) -> Result<(), LinkError> {
        let Some(asked) = self.guests.as_mut().and_then(|guests| guests.next()) else {
            return Ok(());
        };
        let GuestLine { line, selection, answer: to } = asked;
        if let (BEGAN, Selection::One(axis)) = (line.as_slice(), selection) {
            let from = self.travels.from(axis).map(|from| from.to_string());
            let _ = to.send(from.or(Some("E".to_owned())));
            return Ok(());
        }
        let command = parsed(&line);
        let change = command.filter(|command| Matter::of(*command) == Matter::Changes);
        // K applies to all axes, and needs no selection.
        let axes = if command == Some(Command::Kill) { Selection::All } else { selection };
        if command == Some(Command::Status) || change.is_some_and(|line| line != Command::Kill) {
            match self.select(axes).await {
                // The selection is uncertain: the line could reach another axis than the guest's.
                Err(LinkError::Silent) => {
                    let _ = to.send(None);
                    return Ok(());
                }
                selected => selected?,
            }
        }
        let answer = self.say(&line).await?;
        if let Some(change) = change
            && answer.as_ref().is_some_and(|answer| answer.starts_with('Y'))
        {
            if self.changes.len() >= CHANGES {
                self.changes.pop_front();
            }
            self.changes.push_back(self.travels.change(axes, change));
            self.changed = true;
        }
        // The guest may be gone, and need no answer.
        let _ = to.send(answer);
        Ok(())
    }
}
