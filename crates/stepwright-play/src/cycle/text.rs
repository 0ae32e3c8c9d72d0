//! The text of a cycle file. A mistake in it ends the player.

use std::fmt::Display;
use std::ops::{Deref, Range};

use stepwright_cyclefile::CycleText;

use crate::PlayError;

/// A file and its name.
pub struct PlayText(CycleText);

impl PlayText {
    /// A text, under a name for messages.
    pub fn named(name: &str, text: &str) -> PlayText {
        PlayText(CycleText::named(name, text))
    }

    /// An error at this position.
    pub fn blame(&self, span: Range<usize>, what: impl Display) -> PlayError {
        self.0.blame(span, what).into()
    }
}

impl Deref for PlayText {
    type Target = CycleText;

    fn deref(&self) -> &CycleText {
        &self.0
    }
}
