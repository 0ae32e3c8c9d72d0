//! The text of a cycle file, and where a mistake stands in it.

use std::fmt;
use std::ops::Range;

/// A file has this many bytes at most: 1 MB. Read and checked it takes some fifty times
/// as much memory.
pub const LONGEST: usize = 1_000_000;

/// Of a line that is longer this many characters are shown, around the mistake.
const SHOWN: usize = 120;

/// Of a text in a message.
const SAID: usize = 300;

/// Of what was found where something else is expected.
const FOUND: usize = 80;

/// A mistake in a cycle file, or why a cycle of it can't run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// What is wrong, behind the file, the line and the column, and the line itself.
    pub message: String,
    /// What can be done about it.
    pub hint: Option<String>,
    /// What is wrong, without its place.
    pub what: String,
    /// The line, from 1.
    pub line: usize,
}

impl FileError {
    /// The same with what can be done about it.
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

/// The text of a cycle file, and what it is called.
pub struct CycleText {
    name: String,
    /// The text.
    pub text: String,
}

impl CycleText {
    /// A text, under a name for messages.
    pub fn named(name: impl Into<String>, text: impl Into<String>) -> CycleText {
        CycleText { name: name.into(), text: text.into() }
    }

    /// The line of a place, from 1.
    pub fn line(&self, at: usize) -> usize {
        let before = self.text.as_bytes().iter().take(at);
        before.filter(|byte| **byte == b'\n').count() + 1
    }

    /// What is wrong at this place: the file, the line, and the line itself, of a long
    /// one the part around it.
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

/// What a reader of TOML says, with numbers instead of the types of our code, and what is expected
/// to be seen however long is what was found.
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
