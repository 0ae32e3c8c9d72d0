//! Errors: what is wrong, where, what is allowed, and what to do.

use core::fmt;

/// A refused line. It had no effect.
///
/// ```
/// use stepwright_gcode::Reader;
/// let mut reader = Reader::default();
/// let error = b"G1 X10\n".iter().find_map(|&byte| reader.push(byte)).unwrap().unwrap_err();
/// assert_eq!((error.fault.number(), error.line, error.column), (22, 1, 1));
/// assert_eq!(
///     error.to_string(),
///     "line 1, column 1: error 22: no feed rate is set: write F with a number above 0; with G93 \
///      in each block that moves at a feed rate"
/// );
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Error {
    /// The line, from 1; CR, LF and CR LF each end one.
    pub line: u32,
    /// The first byte of the wrong word or character in the line, from 1. A byte order mark before the first
    /// line is not counted.
    pub column: u16,
    /// What is wrong.
    pub fault: Fault,
}

impl core::error::Error for Error {}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Error { line, column, fault } = self;
        write!(f, "line {line}, column {column}: error {}: {fault}", fault.number())
    }
}

/// What can be wrong with a line. A `char` is the letter of the word.
///
/// The numbers are those of grbl 1.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// 1: no letter where a word begins.
    Letter,
    /// 1: a byte order mark that does not begin the input.
    Mark,
    /// 2: no number after a letter.
    Number,
    /// 2: a number of 10,000,000 or more; a length beyond 1,000,000 mm.
    TooLarge,
    /// 3: a line that begins with `$`.
    System,
    /// 4: a negative number where none is allowed.
    Negative(char),
    /// 11: more bytes without blanks and comments than this limit.
    LineLength(u16),
    /// 11: more bytes with blanks and comments than this limit.
    Endless(u16),
    /// 20: a letter that is not in the dialect.
    Word(char),
    /// 20: a G code that is not in the dialect, or an L of G10.
    GCode,
    /// 20: an M code that is not in the dialect.
    MCode,
    /// 21: two codes of one modal group.
    Group,
    /// 22: a move without a feed rate.
    NoFeed,
    /// 23: a fraction where none is allowed.
    Fraction(char),
    /// 24: two codes that both use axis words.
    AxisConflict,
    /// 25: a word that appears twice.
    Twice(char),
    /// 26: a code without the axis words that it needs.
    NoAxis,
    /// 27: a line number that is not a whole number up to 9,999,999.
    LineNumber,
    /// 28: a code without this word, which it needs.
    Missing(char),
    /// 29: a coordinate system beyond G59.
    NoSystem,
    /// 30: G53 in another motion mode than G0 and G1.
    MachineMode,
    /// 31: axis words that no code uses.
    AxisUnused,
    /// 32: an arc without an axis word of its plane.
    ArcEnd,
    /// 33: an arc whose ends differ in their distance from the centre, or are at the centre.
    ArcRadii,
    /// 33: an arc by radius that ends where it starts.
    ArcClosed,
    /// 33: a probe to where the machine is.
    ProbeHere,
    /// 33: a position or an offset beyond the range.
    TooFar,
    /// 34: a radius that is less than half the distance to the end.
    ArcRadius,
    /// 35: an arc without a radius, and without an offset in its plane.
    ArcCentre,
    /// 36: a word that no code uses.
    Unused(char),
    /// 37: a tool length on another axis than Z, or without Z.
    ToolAxis,
    /// 38: a tool number beyond 255.
    Tool,
}

impl Fault {
    /// The error number of grbl 1.1.
    pub const fn number(self) -> u8 {
        use Fault::*;
        match self {
            Letter | Mark => 1,
            Number | TooLarge => 2,
            System => 3,
            Negative(_) => 4,
            LineLength(_) | Endless(_) => 11,
            Word(_) | GCode | MCode => 20,
            Group => 21,
            NoFeed => 22,
            Fraction(_) => 23,
            AxisConflict => 24,
            Twice(_) => 25,
            NoAxis => 26,
            LineNumber => 27,
            Missing(_) => 28,
            NoSystem => 29,
            MachineMode => 30,
            AxisUnused => 31,
            ArcEnd => 32,
            ArcRadii | ArcClosed | ProbeHere | TooFar => 33,
            ArcRadius => 34,
            ArcCentre => 35,
            Unused(_) => 36,
            ToolAxis => 37,
            Tool => 38,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        use Fault::*;
        f.write_str(match self {
            Letter => "no word begins here: a word is a letter and a number, as in G1 or X-2.5",
            Mark => {
                "a byte order mark (U+FEFF) stands here: it is allowed at the start of a file \
                     alone; remove it"
            }
            Number => {
                "a number is missing: write digits, before them a sign and among them a point \
                       if need be, as in -2.5"
            }
            TooLarge => {
                "the number is too large: less than 10,000,000 is allowed, and at most \
                         1,000,000 mm for a length or a feed rate"
            }
            System => "a line with $ is an order to a controller: send it apart from the G-code",
            Negative(letter) => return write!(f, "{letter} is negative: write 0 or more"),
            LineLength(limit) => {
                return write!(
                    f,
                    "the line is too long: at most {limit} characters are allowed, without blanks \
                     and comments; write it as several"
                );
            }
            Endless(limit) => {
                return write!(
                    f,
                    "the line is too long: at most {limit} characters are allowed, with blanks and \
                     comments; is it a file of G-code?"
                );
            }
            Word(letter) => {
                return write!(
                    f,
                    "there is no word {letter}: the letters are F, G, I to N, P, R to T and X to Z"
                );
            }
            GCode => {
                "this code is not supported: there are G0 to G4, G10 L2 and L20, G17 to G21, \
                      G28, G28.1, G30, G30.1, G38.2 to G38.5, G40, G43.1, G49, G53 to G59, G61, \
                      G64, G80, G90, G91, G91.1, G92, G92.1, G93 and G94"
            }
            MCode => "this code is not supported: there are M0 to M5, M7 to M9 and M30",
            Group => {
                "an earlier code of this block is of the same modal group: write one of them \
                      in another block"
            }
            NoFeed => {
                "no feed rate is set: write F with a number above 0; with G93 in each block \
                       that moves at a feed rate"
            }
            Fraction(letter) => return write!(f, "{letter} takes a whole number"),
            AxisConflict => {
                "two codes of this block use axis words (G0 to G3, G10, G28, G30, G38, \
                             G43.1, G49, G92): write one of them in another block"
            }
            Twice(letter) => {
                return write!(f, "{letter} stands twice in this block: remove one of them");
            }
            NoAxis => "this code needs an axis word: add X, Y or Z",
            LineNumber => "N takes a whole number up to 9,999,999",
            Missing(letter) => return write!(f, "a word that is needed is missing: add {letter}"),
            NoSystem => {
                "there is no such coordinate system: G54 to G59 are there, and P1 to P6 for \
                         them, P0 for the present one"
            }
            MachineMode => "G53 works with G0 and G1 alone: write one of them in this block",
            AxisUnused => {
                "no motion mode is set (G80), so nothing uses this word: write G0 or G1 \
                           before it"
            }
            ArcEnd => {
                "an arc needs an axis word of its plane: add X or Y for G17, Z or X for G18, \
                       Y or Z for G19"
            }
            ArcRadii => {
                "the centre of an arc must be equally far from both ends, and not on them: \
                         within 0.005 mm, or 0.1 % of the radius and 0.5 mm; check I, J, K and the \
                         end"
            }
            ArcClosed => {
                "an arc by radius ends where it starts: write a full circle with I, J or K"
            }
            ProbeHere => "the machine is at the end of this probe already: move away before it",
            TooFar => {
                "a position or an offset is beyond 1,000,000 mm of the machine's zero: check \
                       the axis words and the offsets"
            }
            ArcRadius => "the radius is less than half the way to the end: write a larger R",
            ArcCentre => {
                "an arc needs R, or an offset of its centre in its plane: add I or J for \
                          G17, K or I for G18, J or K for G19"
            }
            Unused(letter) => {
                return write!(f, "no code of this block uses {letter}: remove it");
            }
            ToolAxis => "G43.1 takes Z and no other axis: write the length of the tool as Z",
            Tool => "there is no such tool: 0 to 255 are allowed",
        })
    }
}
