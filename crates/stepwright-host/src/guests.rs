//! Other programs that ask a board through the one that holds its line.

use std::sync::mpsc::Sender;

use stepwright_protocol::{Command, Reply};

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
