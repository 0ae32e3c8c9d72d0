//! The text of a cycle file, and where a mistake stands in it.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::failure::Failure;

/// A file and what it is called.
pub struct Text {
    path: PathBuf,
    pub text: String,
}

impl Text {
    /// Reads a file; `-` is standard input.
    pub fn read(path: &Path) -> Result<Text, Failure> {
        let text = if path == Path::new("-") {
            std::io::read_to_string(std::io::stdin())
        } else {
            fs::read_to_string(path)
        };
        let text = text.map_err(|error| Failure::file("read", path, &error))?;
        Ok(Text { path: path.to_owned(), text })
    }

    /// What is wrong at this place: the file, the line, and the line itself.
    pub fn blame(&self, span: Range<usize>, what: impl std::fmt::Display) -> Failure {
        let at = span.start.min(self.text.len());
        let before = self.text.get(..at).unwrap_or("");
        let line = before.matches('\n').count();
        let column = before.rsplit('\n').next().unwrap_or("").chars().count();
        let shown = self.text.lines().nth(line).unwrap_or("");
        let number = line + 1;
        let place = self.path.display();
        Failure::new(format!(
            "{place}:{number}:{}: {what}\n{number:>6} | {shown}\n       | {:column$}^",
            column + 1,
            ""
        ))
    }
}
