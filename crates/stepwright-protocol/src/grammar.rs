//! The lines of the protocol, one row each. [`Command`], its parser, its writer, the condition for
//! taking a line, the table in the documentation and the help of the command are made from the
//! rows: a new line needs a row here and an arm in `slave.rs`.

use core::fmt;

use crate::axis::{AxisId, MAX_AXES, Selection};
use crate::command::BadLine;
use crate::flash::{Text, flash, text};
use crate::number::{
    Direction, Distance, LeaseMillis, MilliSpeed, RampSteps, StartSpeed, Tens, TopSpeed,
    WholeAccel, WholeJerk,
};
use crate::raw_line::RawLine;
use crate::setting::{Setting, Value};
use crate::text::Piece;

/// The conditions for taking a line, and the parts after its letter: a bit each.
pub(crate) mod flag {
    /// A sign follows the letter.
    pub(crate) const SIGN: u8 = 1;
    /// A number ends the line.
    pub(crate) const NUMBER: u8 = 2;
    /// The number may be 0.
    pub(crate) const ZERO: u8 = 4;
    /// The line begins with `$`: the letter of its row is not its first byte.
    pub(crate) const SETTING: u8 = 8;
    /// Refused while it is not clear which axes are addressed.
    pub(crate) const NAMED: u8 = 16;
    /// Taken only in an open order.
    pub(crate) const OPEN: u8 = 32;
    /// Taken only while every selected axis is ready.
    pub(crate) const IDLE: u8 = 64;
    /// Taken only while every axis of the board is ready.
    pub(crate) const REST: u8 = 128;
}

/// The part of a line after its letter.
pub(crate) trait Argument: Copy {
    /// The form of the argument.
    const SHAPE: Shape;
    /// The argument of this line, `None` outside its range.
    fn of(raw: &RawLine) -> Option<Self>;
    /// Piece `n` of its text, counted from 0.
    fn piece(self, n: u8) -> Option<Piece>;
}

/// The form of an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape {
    /// Whether it begins with `+` or `-`.
    sign: bool,
    /// The smallest and the largest number at its end.
    number: Option<(u32, u32)>,
    /// Its description if it has neither sign nor number.
    words: &'static str,
}

impl Shape {
    /// No argument.
    pub(crate) const NONE: Shape = Shape { sign: false, number: None, words: "" };
    /// A sign alone.
    pub(crate) const SIGN: Shape = Shape { sign: true, ..Shape::NONE };

    /// A number from `smallest` to `largest`.
    pub(crate) const fn number(smallest: u32, largest: u32) -> Shape {
        Shape { number: Some((smallest, largest)), ..Shape::NONE }
    }

    /// A sign and a number up to `largest`.
    pub(crate) const fn signed(largest: u32) -> Shape {
        Shape { sign: true, ..Shape::number(0, largest) }
    }

    /// The name of a setting, or the text after the `$`.
    pub(crate) const fn setting(words: &'static str) -> Shape {
        Shape { words, ..Shape::NONE }
    }

    /// The chip's row: the letter, the flags and the position of the largest number.
    const fn row(self, letter: u8, when: u16) -> [u8; ROW] {
        let (mut flags, mut largest) = (when as u8, 0);
        if self.sign {
            flags |= flag::SIGN;
        }
        if let Some((smallest, most)) = self.number {
            // −2³¹ is allowed too.
            largest = most + self.sign as u32;
            flags |= flag::NUMBER | if smallest == 0 { flag::ZERO } else { 0 };
        }
        let mut place = 0;
        while LARGEST[place] != largest {
            place += 1; // a number that is missing there fails to compile
        }
        [letter, flags, (COUNT * ROW + 1 + 4 * place) as u8]
    }
}

/// The largest numbers of all rows. A chip holds each number once.
const LARGEST: [u32; 9] = [
    0,
    MAX_AXES as u32,
    Tens::LARGEST.get(),
    LeaseMillis::LARGEST.get(),
    TopSpeed::LARGEST.get(),
    WholeAccel::LARGEST.get(),
    MilliSpeed::LARGEST.get(),
    i32::MIN.unsigned_abs(),
    WholeJerk::LARGEST.get(),
];

impl Argument for () {
    const SHAPE: Shape = Shape::NONE;

    fn of(_: &RawLine) -> Option<()> {
        Some(())
    }

    fn piece(self, _: u8) -> Option<Piece> {
        None
    }
}

impl Argument for Setting {
    const SHAPE: Shape = Shape::setting("<name>");

    fn of(raw: &RawLine) -> Option<Setting> {
        Some(raw.setting)
    }

    fn piece(self, n: u8) -> Option<Piece> {
        (n == 0).then_some(Piece::Text(self.text()))
    }
}

impl Argument for Value {
    const SHAPE: Shape = Shape::setting("<name>=<number>");

    fn of(raw: &RawLine) -> Option<Value> {
        Value::new(raw.setting, raw.number)
    }

    fn piece(self, n: u8) -> Option<Piece> {
        match n {
            0 => Some(Piece::Text(self.setting().text())),
            1 => Some(Piece::Text(text!("="))),
            2 => Some(Piece::Number(self.number())),
            _ => None,
        }
    }
}

/// The bytes of a row.
const ROW: usize = 3;

/// The row of a letter in the chip's table: the index of the row after it.
#[derive(Clone, Copy)]
pub(crate) struct Row(u8);

impl Row {
    /// The row of this letter.
    #[inline(never)]
    pub(crate) fn of(letter: u8) -> Option<Row> {
        let mut at = 0u8;
        loop {
            let first = byte(at);
            at = at.wrapping_add(ROW as u8);
            if first == 0 {
                return None;
            }
            if first == letter {
                return Some(Row(at));
            }
        }
    }

    /// The conditions for taking the line, and the parts after its letter: bits of [`flag`].
    pub(crate) fn flags(self) -> u8 {
        byte(self.0.wrapping_sub(2))
    }

    /// The largest allowed number.
    pub(crate) fn largest(self) -> u32 {
        let from = byte(self.0.wrapping_sub(1));
        (0..4).fold(0, |number, n| number << 8 | u32::from(byte(from.wrapping_add(n))))
    }
}

/// A byte of the rows; 0 past the end.
#[cfg_attr(target_arch = "avr", inline(never))]
fn byte(at: u8) -> u8 {
    const { assert!(LENGTH <= 256) };
    ROWS.byte(at.into()).unwrap_or(0)
}

/// The form of a line: one row of the grammar.
///
/// ```
/// use stepwright_protocol::Form;
/// let form = Form::of(b"T1000").unwrap();
/// assert_eq!(form.to_string(), "T<1…999>");
/// assert_eq!(form.help(), "top speed, in tens of steps/s");
/// assert!(Form::of(b"x").is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Form {
    text: &'static str,
    shape: Shape,
    flags: u16,
    answer: &'static str,
    help: &'static str,
}

impl Form {
    /// The letters that a line of this form begins with.
    pub const fn text(&self) -> &'static str {
        self.text
    }

    /// The effect of the line, or the value that it asks for.
    pub const fn help(&self) -> &'static str {
        self.help
    }

    /// Whether the line means the same on a board with another program.
    pub fn is_common(&self) -> bool {
        ["Z", "K", "I", "F", "V", "?"].contains(&self.text)
    }

    /// The answer, unless the line is refused.
    pub const fn answer(&self) -> &'static str {
        self.answer
    }

    /// The condition for taking the line.
    pub const fn when(&self) -> &'static str {
        match self.flags & !(NAMED | SETTING) {
            ANY => "at any time",
            IDLE | READY => "axis ready",
            CHANGE => "axis ready, or on the way",
            MOVING => "on the way",
            OPEN => "in an order",
            REST => "every axis ready",
            _ => "in an order, axis ready",
        }
    }

    /// The form whose letters this line begins with.
    pub fn of(line: &[u8]) -> Option<&'static Form> {
        let named = |form: &&Form| line.starts_with(form.text.as_bytes());
        match line {
            b"$" | b"$reset" => Form::ALL.iter().find(|form| form.text.as_bytes() == line),
            [b'$', name @ ..] => {
                let text = if name.contains(&b'=') { "<name>=" } else { "<name>" };
                Form::ALL.iter().find(|form| form.shape.words.starts_with(text) && form.text == "$")
            }
            [b'P', ..] => Form::ALL.iter().find(|form| form.text == "PO"),
            _ => Form::ALL.iter().find(named),
        }
    }
}

/// For a person to read: the letters, and the range of the argument.
impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text)?;
        f.write_str(self.shape.words)?;
        if self.shape.sign {
            f.write_str("±")?;
        }
        match self.shape.number {
            Some((smallest, largest)) => write!(f, "<{smallest}…{largest}>"),
            None => Ok(()),
        }
    }
}

/// Makes the rows, [`Command`], and the code that reads and writes it.
macro_rules! lines {
    (@argument) => { () };
    (@argument $argument:ty) => { $argument };
    (@pattern $name:ident) => { Command::$name };
    (@pattern $name:ident $value:ident) => { Command::$name(_) };
    (@piece $n:ident) => { ().piece($n) };
    (@piece $n:ident $value:ident) => { $value.piece($n) };
    ($(
        $letter:tt $text:literal $name:ident $(($value:ident: $argument:ty))?:
            $when:expr, $answer:literal, $help:literal;
    )*) => {
        /// A parsed line of the master. Every value is inside its range.
        ///
        /// `PO` to `V` except `@` are the Nano slave's lines, the rest are Stepwright's extensions.
        ///
        /// ```
        /// use stepwright_protocol::{BadLine, Command, Distance};
        /// let go = Command::parse(b"G+4000").unwrap();
        /// assert_eq!(go, Command::Go(Distance::new(4000)));
        /// assert_eq!(go.bytes().collect::<Vec<u8>>(), b"G+4000\r");
        /// assert_eq!(Command::parse(b"G4000"), Err(BadLine::Unknown));
        /// assert_eq!(Command::parse(b"S1000"), Err(BadLine::Range));
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Command {
            $(
                #[doc = concat!("`", $text, "`: ", $help, ".")]
                $name $(($argument))?,
            )*
        }

        impl Form {
            /// Every line, in the order of the documentation.
            pub const ALL: &[Form] = &[$(Form {
                text: $text,
                shape: <lines!(@argument $($argument)?) as Argument>::SHAPE,
                flags: $when,
                answer: $answer,
                help: $help,
            }),*];
        }

        /// The number of rows.
        const COUNT: usize = [$($help),*].len();

        /// The rows of the chip, a 0, and the largest numbers.
        static ROWS: Text = flash!(LENGTH, joined());
        const LENGTH: usize = COUNT * ROW + 1 + LARGEST.len() * 4;

        const fn joined() -> [u8; LENGTH] {
            let rows = [$(
                <lines!(@argument $($argument)?) as Argument>::SHAPE.row($letter, $when)
            ),*];
            let mut bytes = [0; LENGTH];
            let mut at = 0;
            while at < COUNT * ROW {
                bytes[at] = rows[at / ROW][at % ROW];
                at += 1;
            }
            at += 1;
            let table = at;
            while at < LENGTH {
                bytes[at] = LARGEST[(at - table) / 4].to_be_bytes()[(at - table) % 4];
                at += 1;
            }
            bytes
        }

        impl Command {
            /// The command of a line whose letter and argument have been read.
            pub(crate) fn of(raw: &RawLine) -> Result<Command, BadLine> {
                Ok(match raw.letter {
                    $($letter => Command::$name $((
                        <$argument as Argument>::of(raw).ok_or(BadLine::Range)?
                    ))?,)*
                    _ => return Err(BadLine::Unknown),
                })
            }

            /// The letters that its line begins with.
            pub(crate) fn letters(self) -> Text {
                match self { $(lines!(@pattern $name $($value)?) => text!($text)),* }
            }

            /// Piece `n` of its argument, counted from 0.
            pub(crate) fn argument(self, n: u8) -> Option<Piece> {
                match self {
                    $(Command::$name $(($value))? => lines!(@piece n $($value)?)),*
                }
            }
        }
    };
}

const NAMED: u16 = flag::NAMED as u16;
const OPEN: u16 = flag::OPEN as u16;
const IDLE: u16 = flag::IDLE as u16;
const REST: u16 = flag::REST as u16;
const SETTING: u16 = flag::SETTING as u16;
/// Taken while the axis is ready, and during motion outside an order. The arm in the slave checks
/// this.
const CHANGE: u16 = 256;
/// Taken while the axis that the line names is ready. The arm in the slave checks this.
const READY: u16 = 1024;
/// Taken while the axis moves. The arm in the slave checks this.
const MOVING: u16 = 512;

/// The letter of a top speed in 0.001 steps/s.
pub(crate) const MILLI: u8 = b'm';
/// The internal letter of `$name`.
pub(crate) const ONE: u8 = b'n';
/// The internal letter of `$name=number`.
pub(crate) const SET: u8 = b'=';
/// The internal letter of `$reset`.
pub(crate) const RESET: u8 = b'r';
/// Taken at any time.
const ANY: u16 = 0;

lines! {
    b'P' "PO" Program: IDLE, "Y", "opens an order, and selects axis 1; `P0` is the same line";
    b'S' "S" StartTens(n: Tens): NAMED | IDLE, "Y", "start/stop speed, in tens of steps/s";
    b'T' "T" TopTens(n: Tens): NAMED | IDLE, "Y", "top speed, in tens of steps/s";
    b'R' "R" Ramp(n: RampSteps): NAMED | IDLE, "Y", "length of both ramps, in steps";
    b'G' "G" Go(steps: Distance): NAMED | OPEN | IDLE, "Y",
        "travel by this many steps, + clockwise, from where the last travel ended";
    b'g' "g" Run(direction: Direction): NAMED | IDLE, "Y",
        "travel until a stop; outside an order it starts at once";
    b'E' "E" Execute: OPEN, "Y", "starts the order";
    b'Z' "Z" Stop: ANY, "Y", "stops along the ramp; the position stays known";
    b'K' "K" Kill: ANY, "Y", "stops all axes at once; an axis that moved has lost its position";
    b'I' "I" Zero(axis: AxisId): READY, "Y", "the position of this axis is 0";
    b'F' "F" Status: ANY, "R or B", "are the selected axes ready, or busy?";
    b'V' "V" Position(axis: AxisId): ANY, "a number", "the position of this axis, in steps";
    b'A' "A" Select(axes: Selection): ANY, "Y", "the next lines address this axis, `A0` all axes";
    b's' "s" Start(n: StartSpeed): NAMED | IDLE, "Y", "start/stop speed, in steps/s";
    b't' "t" Top(n: TopSpeed): NAMED | CHANGE, "Y", "top speed, in steps/s";
    MILLI "m" Milli(n: MilliSpeed): NAMED | CHANGE, "Y", "top speed, in 0.001 steps/s";
    b'a' "a" Accel(n: WholeAccel): NAMED | CHANGE, "Y", "acceleration of the ramp up, in steps/s²";
    b'd' "d" Decel(n: WholeAccel): NAMED | CHANGE, "Y", "deceleration of the ramp down, in steps/s²";
    b'j' "j" Jerk(n: WholeJerk): NAMED | IDLE, "Y",
        "jerk, in steps/s³; 0: none; `PO` sets it to 0; on a board that can `jerk`";
    b'@' "@" Retarget(steps: Distance): NAMED | MOVING, "Y",
        "the travel in progress ends this many steps from where it began";
    b'L' "L" Lease(n: LeaseMillis): ANY, "Y",
        "moving axes brake when no line comes for this many ms; 0: never";
    b'?' "?" Info: ANY, "a line", "what the board is, what it can do, and what went wrong";
    b'!' "!" Clear: ANY, "Y", "clears `late`, `refused`, `last`, `stop` and `errors`";
    b'$' "$" Settings: SETTING, "a line", "all settings";
    ONE "$" Setting(setting: Setting): SETTING, "a line", "this setting";
    SET "$" Set(value: Value): SETTING | REST, "Y", "sets this setting, also for after power-up";
    RESET "$reset" Reset: SETTING | REST, "Y", "every setting has its default again";
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::collections::BTreeSet;
    use std::string::{String, ToString};
    use std::{format, fs};

    /// The table in the documentation, made from the rows.
    fn table() -> String {
        let mut table = String::from(
            "| line | what it does | when it is taken | answer |\n|---|---|---|---|\n",
        );
        for form in Form::ALL {
            let (when, answer) = (form.when(), form.answer());
            table += &format!("| `{form}` | {} | {when} | {answer} |\n", form.help());
        }
        table += "\nThe programs with other features (Austin's laws, the timed driver, motor cycles) \
                  have these of them, in the same frame, with the same checksum, and every other \
                  row of theirs begins with `:`:\n\n\
                  | line | what it does | answer |\n|---|---|---|\n";
        for form in Form::ALL.iter().filter(|form| form.is_common()) {
            table += &format!("| `{form}` | {} | {} |\n", form.help(), form.answer());
        }
        table += "| `:`… | a row of the program: a letter, and decimal numbers with commas between \
                  them | Y, or numbers with commas between them |\n\n\
                  A byte of 0x80 and more damages its line. Once a line with a checksum was obeyed, \
                  a row without one is refused, until a common line without one is obeyed: a row \
                  that has lost its `*` would be another row.\n";
        table
    }

    #[test]
    fn the_documentation_has_the_table() {
        let place = concat!(env!("CARGO_MANIFEST_DIR"), "/src/grammar.md");
        if std::env::var("STEPWRIGHT_GOLDEN").is_ok_and(|golden| golden == "write") {
            fs::write(place, table()).unwrap();
        }
        let text = fs::read_to_string(place).unwrap();
        assert_eq!(text, table(), "STEPWRIGHT_GOLDEN=write cargo test writes it");
    }

    #[test]
    fn a_letter_has_one_row() {
        let mut letters = BTreeSet::new();
        let mut at = 0;
        while let Some(letter) = ROWS.byte(at).filter(|letter| *letter != 0) {
            assert!(letters.insert(letter), "{letter}");
            let row = Row::of(letter).unwrap();
            let form = Form::ALL[usize::from(at) / ROW];
            // −2³¹ has a sign.
            let sign = u32::from(form.shape.sign);
            assert_eq!(row.largest(), form.shape.number.map_or(0, |(_, largest)| largest + sign));
            assert_eq!(row.flags() & flag::NUMBER != 0, form.shape.number.is_some());
            at += ROW as u16;
        }
        assert_eq!(letters.len(), Form::ALL.len());
        assert!(Row::of(b'x').is_none() && Row::of(0).is_none());
    }

    #[test]
    fn a_line_has_the_form_of_its_letters() {
        for (line, form) in [
            (&b"PO"[..], "PO"),
            (b"P7", "PO"),
            (b"S1000", "S<1…999>"),
            (b"G5", "G±<0…2147483647>"),
            (b"g", "g±"),
            (b"A9", "A<0…8>"),
            (b"I0", "I<1…8>"),
            (b"j5", "j<0…4000000000>"),
            (b"$", "$"),
            (b"$pulse-us", "$<name>"),
            (b"$pulse-us=0", "$<name>=<number>"),
            (b"$reset", "$reset"),
        ] {
            assert_eq!(Form::of(line).unwrap().to_string(), form, "{line:?}");
        }
        for line in [&b""[..], b"x", b"n", b"=", b"r", b"\xff"] {
            assert_eq!(Form::of(line), None, "{line:?}");
        }
    }
}
