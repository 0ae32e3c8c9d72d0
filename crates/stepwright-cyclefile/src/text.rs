//! The text of a cycle file, and the place of a mistake in it.

use std::fmt;
use std::ops::Range;

/// The most bytes of a file: 1 MB. Reading and checking it takes some fifty times as much memory.
pub const LONGEST: usize = 1_000_000;

/// The most characters that are shown of a line, around the mistake.
const SHOWN: usize = 120;

/// The most characters of a text in a message.
const SAID: usize = 300;

/// The most characters of a value that is not the expected one.
const FOUND: usize = 80;

/// A mistake in a cycle file, or the reason why one of its cycles cannot run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The file, the line, the column and what is wrong, and then the line itself.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
    /// What is wrong, without its place.
    pub what: String,
    /// The line, from 1.
    pub line: usize,
}

impl FileError {
    /// The same error with a hint on what to do about it.
    pub(crate) fn hint(self, hint: impl Into<String>) -> FileError {
        FileError { hint: Some(hint.into()), ..self }
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for FileError {}

/// The text of a cycle file, and its name.
pub struct CycleText {
    name: String,
    /// The text.
    pub text: String,
}

impl CycleText {
    /// A text, with a name for messages.
    pub fn named(name: impl Into<String>, text: impl Into<String>) -> CycleText {
        CycleText { name: name.into(), text: text.into() }
    }

    /// The line of a byte of the text, from 1.
    pub fn line(&self, at: usize) -> usize {
        let before = self.text.as_bytes().iter().take(at);
        before.filter(|byte| **byte == b'\n').count() + 1
    }

    /// The error at this place, with the file, the line number and the line. Of a long line only the part
    /// around the place is shown.
    pub fn blame(&self, span: Range<usize>, what: impl fmt::Display) -> FileError {
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
        let (number, column, place) = (line + 1, column + 1, &self.name);
        let mark = " ".repeat(mark);
        let message =
            format!("{place}:{number}:{column}: {what}\n{number:>6} | {shown}\n       | {mark}^",);
        FileError { message, hint: None, what, line: number }
    }
}

/// The message of the TOML reader, with ranges of numbers instead of the types of our code. The value that was
/// found is shortened, so that the expected one is always seen.
pub(crate) fn plain(said: &str) -> String {
    let Some((found, expected)) = said.rsplit_once(", expected ") else { return said.to_owned() };
    let expected = match expected {
        "u32" => "a whole number, 0 to 4294967295",
        "i32" => "a whole number, -2147483648 to 2147483647",
        "i64" => "a whole number, -9223372036854775808 to 9223372036854775807",
        "f64" => "a number",
        other => other,
    };
    let found = found.replace(" as i128", "").replace(" as u128", "");
    match found.char_indices().nth(FOUND) {
        Some((end, _)) => format!("{}…, expected {expected}", &found[..end]),
        None => format!("{found}, expected {expected}"),
    }
}

/// The part of a line around a column, and the place of that column in the part.
fn part(line: &str, column: usize) -> (String, usize) {
    // A character that moves the cursor would misplace the mark.
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
