//! Lines as they come: bytes to text, and whether a line may be obeyed.

/// Seconds without a line after which lines are obeyed again, behind an error.
pub const QUIET: f64 = 0.25;

/// The longest line, without blanks and comments; grbl's.
const LONGEST: usize = 80;

/// Stands for bytes of a line that were lost. It is no byte of a line.
pub(crate) const SPOILT: u8 = 0xFF;

/// A line that is being put together: capitals, without blanks and comments.
#[derive(Clone, Debug, Default)]
pub(crate) struct Line {
    text: Vec<u8>,
    comment: Comment,
    too_long: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Comment {
    #[default]
    No,
    /// Up to `)`.
    Closed,
    /// Up to the end of the line.
    Rest,
}

impl Line {
    /// Whether nothing of it has come.
    pub fn is_empty(&self) -> bool {
        self.text.is_empty() && self.comment == Comment::No && !self.too_long
    }

    /// Takes a byte; at the end of the line its text, or `Err` if it is too long.
    pub fn take(&mut self, byte: u8) -> Option<Result<Vec<u8>, ()>> {
        match byte {
            b'\r' | b'\n' => {
                let Line { text, too_long, .. } = std::mem::take(self);
                return Some(if too_long { Err(()) } else { Ok(text) });
            }
            SPOILT => self.too_long = true,
            b')' if self.comment == Comment::Closed => self.comment = Comment::No,
            _ if self.comment != Comment::No => {}
            b'(' => self.comment = Comment::Closed,
            b';' => self.comment = Comment::Rest,
            // Blanks and what is no letter of a line.
            0..=b' ' | 0x7F.. => {}
            // As grbl: who wants to skip blocks does not send them.
            b'/' => {}
            _ if self.text.len() == LONGEST => self.too_long = true,
            _ => self.text.push(byte.to_ascii_uppercase()),
        }
        None
    }
}

/// Refuses lines behind one with an error.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lock {
    /// When the last byte of a line came.
    since: Option<f64>,
    /// Never refuses.
    pub off: bool,
}

impl Lock {
    /// A line had an error, at `now`.
    pub fn close(&mut self, now: f64) {
        self.since = Some(now);
    }

    pub fn open(&mut self) {
        self.since = None;
    }

    /// A byte of a line comes.
    pub fn hear(&mut self, now: f64) {
        if let Some(since) = self.since {
            self.since = Some(now).filter(|now| now - since < QUIET);
        }
    }

    pub fn is_closed(&self) -> bool {
        !self.off && self.since.is_some()
    }
}
