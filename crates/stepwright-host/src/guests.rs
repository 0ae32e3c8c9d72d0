//! Other programs that ask a board through the one that holds its line.

use std::sync::mpsc::Sender;

use stepwright_protocol::{AxisId, Command, Reply, Selection};

use crate::conversation::{Conversation, LinkError};

/// A line of a guest.
pub struct GuestLine {
    /// Without its CR.
    pub line: Vec<u8>,
    /// What the guest has selected, to be selected before.
    pub selection: Selection,
    /// Where the answer goes: as it came, or nothing.
    pub answer: Sender<Option<String>>,
}

/// Who asks, and what is noted for whoever comes after us.
pub trait Guests: Send {
    /// A line that a guest wants said, if one does.
    fn next(&mut self) -> Option<GuestLine>;

    /// A line of ours is about to be said.
    fn before(&self, command: Command);

    /// A line of ours was answered.
    fn after(&self, command: Command, reply: Reply);
}

/// What a guest asks the program that holds the port: where did the travel of my axis begin?
const BEGAN: &[u8] = b"@";

/// The most changes that are kept for a holder of the port that does not ask for them.
const CHANGES: usize = 64;

/// What a line is to a guest.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Matter {
    /// It asks, selects or clears.
    Asks,
    /// It changes a travel, or ends it.
    Changes,
    /// It is the holder's alone. An order has several lines, which would mingle with its own.
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

/// A line of a guest, its checksum left out.
pub(crate) fn parsed(line: &[u8]) -> Option<Command> {
    Command::parse(line.split(|byte| *byte == b'*').next()?).ok()
}

/// Whether a guest may say this.
#[cfg(all(unix, feature = "serial"))]
pub(crate) fn is_allowed(line: &[u8]) -> bool {
    line == BEGAN || parsed(line).is_some_and(|command| Matter::of(command) != Matter::Orders)
}

impl Conversation {
    /// Where the travel of an axis began, if the program knows that whose guest we are.
    pub async fn began(&mut self, axis: AxisId) -> Result<Option<i64>, LinkError> {
        self.select(Selection::One(axis)).await?;
        let answer = self.say(BEGAN).await?;
        Ok(answer.and_then(|answer| answer.parse().ok()))
    }

    /// Says what another program wants to be said: one line, then it is our turn again. Our
    /// lease is held by what we say ourselves, not by a crowd that keeps us from saying it.
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
        // K is of all axes, and waits for no selection.
        let axes = if command == Some(Command::Kill) { Selection::All } else { selection };
        if command == Some(Command::Status) || change.is_some_and(|line| line != Command::Kill) {
            match self.select(axes).await {
                // Whatever is selected, it may be another axis than the guest's.
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
        // A guest that is gone needs none.
        let _ = to.send(answer);
        Ok(())
    }
}
