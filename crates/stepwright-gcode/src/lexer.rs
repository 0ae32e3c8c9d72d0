//! Makes words of the bytes of a line, without comments, blanks and case.

use crate::decimal::Scanner;
use crate::words::{Refused, Words};
use crate::{Fault, Options};

/// A line that is being read. The first fault is kept, and ends the reading.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lexer {
    /// The number of bytes so far.
    column: u16,
    /// The number of bytes so far, without blanks and comments.
    length: u16,
    skip: Skip,
    /// The letter whose number is being read, its column, and the number.
    word: Option<(u8, u16, Scanner)>,
    words: Words,
    fault: Option<Refused>,
    /// The number of bytes of a [`MARK`] that came last.
    mark: u8,
}

/// The most bytes of a line with its blanks and comments: the last column.
const LONGEST: u16 = u16::MAX;

/// The byte order mark of UTF-8.
const MARK: [u8; 3] = [0xEF, 0xBB, 0xBF];

/// The part of a line that is skipped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Skip {
    #[default]
    Nothing,
    /// Up to the next `)`.
    Comment,
    /// The rest of the line.
    Rest,
}

impl Lexer {
    /// Whether the line has no byte yet.
    pub fn is_empty(&self) -> bool {
        self.column == 0
    }

    /// Whether another byte would be too many.
    pub fn is_full(&self) -> bool {
        self.column == LONGEST
    }

    /// Whether the line is a byte order mark so far, and nothing else.
    pub fn is_mark(&self) -> bool {
        self.column == 3 && self.mark == 3
    }

    /// Takes a byte that does not end the line.
    pub fn push(&mut self, byte: u8, options: Options) {
        self.column = self.column.saturating_add(1);
        self.mark = match MARK.get(usize::from(self.mark)) {
            Some(&next) if next == byte => self.mark + 1,
            _ => u8::from(byte == MARK[0]),
        };
        match (self.skip, byte) {
            (Skip::Comment, b')') => self.skip = Skip::Nothing,
            (Skip::Comment | Skip::Rest, _) | (_, 0..=b' ') => {}
            (_, b'(') => self.skip = Skip::Comment,
            (_, b';') => self.skip = Skip::Rest,
            _ if self.fault.is_some() => {}
            _ => {
                self.length = self.length.saturating_add(1);
                let read = match (self.length, byte) {
                    (1, b'/') => {
                        if options.block_delete {
                            self.skip = Skip::Rest;
                        }
                        Ok(())
                    }
                    (1, b'%') => {
                        self.skip = Skip::Rest;
                        Ok(())
                    }
                    (1, b'$') => Err((Fault::System, self.column)),
                    (length, _) if length > options.line_limit => {
                        Err((Fault::LineLength(options.line_limit), self.column))
                    }
                    _ => self.read(byte.to_ascii_uppercase()),
                };
                self.fault = read.err();
            }
        }
        let first = self.column.saturating_sub(2);
        if self.mark == 3 && self.fault == Some((Fault::Letter, first)) {
            self.fault = Some((Fault::Mark, first));
        }
    }

    fn read(&mut self, byte: u8) -> Result<(), Refused> {
        if let Some((_, _, number)) = &mut self.word
            && number.push(byte)
        {
            return Ok(());
        }
        self.end_word()?;
        if !byte.is_ascii_uppercase() {
            return Err((Fault::Letter, self.column));
        }
        self.word = Some((byte, self.column, Scanner::default()));
        Ok(())
    }

    fn end_word(&mut self) -> Result<(), Refused> {
        let Some((letter, column, number)) = self.word.take() else { return Ok(()) };
        let value = number.finish().map_err(|fault| (fault, column))?;
        self.words.add(letter, value, column)
    }

    /// The fault of a line of more than [`LONGEST`] bytes.
    pub fn too_long(&self) -> Refused {
        self.fault.unwrap_or((Fault::Endless(LONGEST), self.column))
    }

    /// The words, at the end of the line.
    pub fn finish(mut self) -> Result<Words, Refused> {
        match self.fault {
            Some(fault) => Err(fault),
            None => self.end_word().map(|()| self.words),
        }
    }
}
