//! The text of a cycle file, and where a mistake stands in it.

use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::files;

/// A file has this many bytes at most: 1 MB. Read and checked it takes some fifty times
/// as much memory.
const MOST: usize = 1_000_000;

/// Of a line that is longer this many characters are shown, around the mistake.
const SHOWN: usize = 120;

/// Of a text in a message.
const SAID: usize = 300;

/// A file and what it is called.
pub struct Text {
    path: PathBuf,
    pub text: String,
}

impl Text {
    /// Reads a file; `-` is standard input.
    pub fn read(path: &Path) -> Result<Text, Failure> {
        let text = if path == Path::new("-") {
            files::read_from(std::io::stdin().lock(), path, MOST)
        } else {
            files::read(path, MOST)
        };
        Ok(Text { path: path.to_owned(), text: text? })
    }

    /// A file that is not on a disk.
    pub fn named(name: &str, text: &str) -> Text {
        Text { path: name.into(), text: text.to_owned() }
    }

    #[cfg(test)]
    pub fn of(text: &str) -> Text {
        Text::named("file.toml", text)
    }

    /// The line of a place, from 1.
    pub fn line(&self, at: usize) -> usize {
        let before = self.text.as_bytes().iter().take(at);
        before.filter(|byte| **byte == b'\n').count() + 1
    }

    /// What is wrong at this place: the file, the line, and the line itself, of a long
    /// one the part around it.
    pub fn blame(&self, span: Range<usize>, what: impl std::fmt::Display) -> Failure {
        let at = span.start.min(self.text.len());
        let before = self.text.get(..at).unwrap_or("");
        let line = before.matches('\n').count();
        let column = before.rsplit('\n').next().unwrap_or("").chars().count();
        let (shown, mark) = part(self.text.lines().nth(line).unwrap_or(""), column);
        let what = what.to_string();
        let what = match what.char_indices().nth(SAID) {
            Some((end, _)) => format!("{}…", &what[..end]),
            None => what,
        };
        let (number, column, place) = (line + 1, column + 1, self.path.display());
        let mark = " ".repeat(mark);
        Failure::new(format!(
            "{place}:{number}:{column}: {what}\n{number:>6} | {shown}\n       | {mark}^",
        ))
        .at(what, number)
    }
}

/// The part of a line around a column, and where in it that is.
fn part(line: &str, column: usize) -> (String, usize) {
    // A character that moves the cursor would lead the mark astray.
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    let long = line.chars().nth(SHOWN).is_some();
    let from = if long { column.saturating_sub(SHOWN / 2) } else { 0 };
    let mut rest = line.chars().skip(from);
    let mut shown: String = if from > 0 { "…" } else { "" }.into();
    shown.extend(rest.by_ref().take(SHOWN).map(plain));
    if rest.next().is_some() {
        shown.push('…');
    }
    (shown, column - from + usize::from(from > 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mark_stands_below_its_column_in_lines_of_any_length() {
        for length in [1, 119, 120, 121, 1_000, 100_000] {
            let line = "ä".repeat(length) + "X" + &"y".repeat(length);
            let (shown, mark) = part(&line, length);
            assert_eq!(shown.chars().nth(mark), Some('X'), "{length}");
            assert!(shown.chars().count() <= SHOWN + 2);
            assert_eq!(shown.contains('…'), line.chars().count() > SHOWN, "{length}");
        }
        assert_eq!(part("a\tb\u{1b}[c", 2), ("a b [c".to_owned(), 2));
        assert_eq!(part("", 0), (String::new(), 0));
    }
}
