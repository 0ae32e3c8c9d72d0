//! Other programs that ask a board through the one that holds its line.

use std::sync::mpsc::Sender;

use stepwright_protocol::{AxisId, Command, Reply, Selection};

use crate::conversation::{Conversation, LinkError};

/// A line of a guest.
pub struct GuestLine {
    /// Without its CR.
    pub line: Vec<u8>,
    /// The axis line that the guest has said last, to be said before.
    pub selection: Option<Vec<u8>>,
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

/// A line of a guest, its checksum left out.
fn parsed(line: &[u8]) -> Option<Command> {
    Command::parse(line.split(|byte| *byte == b'*').next()?).ok()
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
        let axes = match selection.as_deref().map(parsed) {
            Some(Some(Command::Select(axes))) => axes,
            _ => Selection::FIRST,
        };
        // An axis line is its own selection, and K is of all axes.
        let of_axis = parsed(&line) != Some(Command::Kill);
        if of_axis && selection.is_some_and(|said| said != line) {
            match self.select(axes).await {
                // Whatever is selected, it may be another axis than the guest's.
                Err(LinkError::Silent) => {
                    let _ = to.send(None);
                    return Ok(());
                }
                selected => selected?,
            }
        }
        if let (BEGAN, Selection::One(axis)) = (line.as_slice(), axes) {
            let from = self.travels.from(axis).map(|from| from.to_string());
            let _ = to.send(from.or(Some("E".to_owned())));
            return Ok(());
        }
        let answer = self.say(&line).await?;
        let accepted = answer.as_ref().is_some_and(|answer| answer.starts_with('Y'));
        if accepted
            && line.first().is_some_and(|letter| b"tmadj@ZK".contains(letter))
            && let Some(command) = parsed(&line)
        {
            self.changes.push(self.travels.change(axes, command));
            self.changed = true;
        }
        // A guest that is gone needs none.
        let _ = to.send(answer);
        Ok(())
    }
}
