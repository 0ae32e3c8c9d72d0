//! Assembles bytes to lines, and decides whether lines are refused after an error.

/// After an error, lines are accepted again after this many seconds without a line.
pub const QUIET: f64 = 0.25;

/// The longest line without blanks and comments, as in grbl.
const LONGEST: usize = 80;

/// Stands for lost bytes of a line. No line contains this byte.
pub(crate) const SPOILT: u8 = 0xFF;

/// An incomplete line, in capitals, without blanks and comments.
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
    /// Whether no byte of the line has come.
    pub fn is_empty(&self) -> bool {
        self.text.is_empty() && self.comment == Comment::No && !self.too_long
    }

    /// Takes a byte. At the end of the line, returns its text, or `Err` if it is too long.
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
            // Blanks and bytes that are not printable ASCII.
            0..=b' ' | 0x7F.. => {}
            // As in grbl: a sender that skips blocks does not send them.
            b'/' => {}
            _ if self.text.len() == LONGEST => self.too_long = true,
            _ => self.text.push(byte.to_ascii_uppercase()),
        }
        None
    }
}

/// Refuses lines after a line with an error.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lock {
    /// The time of the last byte of a line, while closed.
    since: Option<f64>,
    /// Whether lines are never refused.
    pub off: bool,
}

impl Lock {
    /// Closes the lock at `now`, after a line with an error.
    pub fn close(&mut self, now: f64) {
        self.since = Some(now);
    }

    pub fn open(&mut self) {
        self.since = None;
    }

    /// Notes a byte of a line; opens the lock if it comes after [`QUIET`], unless a line `waits` that was
    /// sent before.
    pub fn hear(&mut self, now: f64, waits: bool) {
        if let Some(since) = self.since {
            self.since = Some(now).filter(|now| waits || now - since < QUIET);
        }
    }

    pub fn is_closed(&self) -> bool {
        !self.off && self.since.is_some()
    }
}
