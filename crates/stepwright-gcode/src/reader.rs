//! The reader: bytes in, blocks out.

use crate::lexer::Lexer;
use crate::state::State;
use crate::words::{Refused, Words};
use crate::{Block, Coolant, Error, Length, Modal, Parameter, Point, Spindle};

/// The options of a reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Whether lines that begin with `/` are skipped. Otherwise they are read, as in grbl.
    pub block_delete: bool,
    /// The most bytes of a line, without blanks and comments; 80 by default, as in grbl.
    pub line_limit: u16,
    /// The [`Modal::tolerance`] until G61 or G64 orders another one.
    pub tolerance: Length,
}

impl Default for Options {
    fn default() -> Options {
        Options { block_delete: false, line_limit: 80, tolerance: Length::ZERO }
    }
}

/// Reads G-code, a byte at a time.
///
/// A line with an error changes nothing. The next line is read as usual; the caller decides whether to execute
/// it.
///
/// A byte costs a few comparisons; the end of a line two copies of the reader's state, about
/// 500 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reader {
    options: Options,
    state: State,
    lexer: Lexer,
    /// The number of lines that have ended.
    lines: u32,
    after_cr: bool,
    /// Whether a byte order mark began the input.
    marked: bool,
    /// Whether the line is too long, and its error was returned.
    cut: bool,
}

impl Reader {
    /// A reader at the machine's zero, with no offsets, in millimetres.
    pub fn new(options: Options) -> Reader {
        let mut reader = Reader { options, ..Reader::default() };
        reader.state.modal.tolerance = options.tolerance;
        reader
    }

    /// Takes a byte. At the end of a line, even of an empty one, returns the block of the line or its error.
    /// CR, LF and CR LF each end a line.
    ///
    /// If a line has more than 65,535 bytes, the error is returned before its end, and nothing at its end.
    pub fn push(&mut self, byte: u8) -> Option<Result<Block, Error>> {
        let after_cr = core::mem::replace(&mut self.after_cr, byte == b'\r');
        match byte {
            b'\n' if after_cr => None,
            b'\r' | b'\n' if self.cut => {
                self.cut = false;
                None
            }
            b'\r' | b'\n' => Some(self.end_line()),
            _ if self.cut => None,
            _ if self.lexer.is_full() => {
                self.cut = true;
                let refused = core::mem::take(&mut self.lexer).too_long();
                Some(self.end_with(Err(refused)))
            }
            _ => {
                self.lexer.push(byte, self.options);
                if self.lines == 0 && !self.marked && self.lexer.is_mark() {
                    (self.lexer, self.marked) = (Lexer::default(), true);
                }
                None
            }
        }
    }

    /// Returns the block of a last line that no CR or LF ends.
    pub fn finish(&mut self) -> Option<Result<Block, Error>> {
        if self.lexer.is_empty() { None } else { Some(self.end_line()) }
    }

    fn end_line(&mut self) -> Result<Block, Error> {
        let words = core::mem::take(&mut self.lexer).finish();
        self.end_with(words)
    }

    fn end_with(&mut self, words: Result<Words, Refused>) -> Result<Block, Error> {
        self.lines = self.lines.saturating_add(1);
        let line = self.lines;
        let mut state = self.state;
        match words.and_then(|words| state.execute(words)) {
            Ok(block) => {
                self.state = state;
                Ok(Block { line, ..block })
            }
            Err((fault, column)) => Err(Error { line, column, fault }),
        }
    }

    /// The modes in force for the next block.
    pub fn modal(&self) -> Modal {
        self.state.modal
    }

    /// The position of the machine after all blocks that were returned.
    pub fn position(&self) -> Point {
        self.state.position
    }

    /// Sets the position of the machine: after power-up, a probe, or a move that was stopped.
    pub fn set_position(&mut self, position: Point) {
        self.state.position = position;
    }

    /// Sets the state of the spindle, if something other than G-code changed it. A block has an
    /// [effect](crate::Effect) on the spindle only if it changes this state.
    pub fn set_spindle(&mut self, spindle: Spindle) {
        self.state.modal.spindle = spindle;
    }

    /// Sets the state of the coolant in the same way.
    pub fn set_coolant(&mut self, coolant: Coolant) {
        self.state.modal.coolant = coolant;
    }

    /// The value of a parameter.
    ///
    /// ```
    /// use stepwright_gcode::{Parameter, Reader, System};
    /// let mut reader = Reader::default();
    /// for byte in *b"G10 L2 P2 X12.5 Z-3\n" {
    ///     reader.push(byte).transpose()?;
    /// }
    /// let zero = reader.parameter(Parameter::System(System::G55));
    /// assert_eq!(zero.to_string(), "X12.5 Y0 Z-3");
    /// # Ok::<(), stepwright_gcode::Error>(())
    /// ```
    pub fn parameter(&self, parameter: Parameter) -> Point {
        self.state.parameter(parameter)
    }

    /// Sets a parameter to a stored value. Of the length of the tool only Z is used.
    pub fn set_parameter(&mut self, parameter: Parameter, value: Point) {
        self.state.set_parameter(parameter, value);
    }
}
