//! Reads the text of a cycle file. A mistake in it ends the command.

use std::path::Path;

use stepwright_cyclefile::{FileError, LONGEST};
use stepwright_play::cycle::PlayText;

use crate::failure::Failure;
use crate::files;

/// Reads a file; `-` is standard input.
pub fn read(path: &Path) -> Result<PlayText, Failure> {
    let text = if path == Path::new("-") {
        files::read_from(std::io::stdin().lock(), path, LONGEST)
    } else {
        files::read(path, LONGEST)
    };
    Ok(PlayText::named(&path.display().to_string(), &text?))
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
