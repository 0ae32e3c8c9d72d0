//! The text of a cycle file, whose mistakes end the command.

use std::fmt::Display;
use std::ops::{Deref, Range};
use std::path::Path;

use stepwright_cyclefile::{CycleText, FileError, LONGEST};

use crate::failure::Failure;
use crate::files;

/// A file and what it is called.
pub struct Text(CycleText);

impl Text {
    /// Reads a file; `-` is standard input.
    pub fn read(path: &Path) -> Result<Text, Failure> {
        let text = if path == Path::new("-") {
            files::read_from(std::io::stdin().lock(), path, LONGEST)
        } else {
            files::read(path, LONGEST)
        };
        Ok(Text::named(&path.display().to_string(), &text?))
    }

    /// A file that is not on a disk.
    pub fn named(name: &str, text: &str) -> Text {
        Text(CycleText::named(name, text))
    }

    /// What is wrong at this place.
    pub fn blame(&self, span: Range<usize>, what: impl Display) -> Failure {
        self.0.blame(span, what).into()
    }
}

impl Deref for Text {
    type Target = CycleText;

    fn deref(&self) -> &CycleText {
        &self.0
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Failure {
        let failure = Failure::new(error.message).at(error.what, error.line);
        match error.hint {
            Some(hint) => failure.hint(hint),
            None => failure,
        }
    }
}
