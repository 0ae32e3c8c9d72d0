//! The line that a chip prints.
//!
//! ```text
//! stepwright-selftest format=1 chip=rp2040 firmware=0.1.0-1a2b3c4d hz=125000000 orders=16 plan=0b5e1c9d
//! steps=4711 edges=4711 off=74 late=0 khz=125000 crc=9abcdef0
//! ```
//!
//! One line, its words separated by a space. `crc` is the CRC-32 of all before ` crc=`; `firmware`
//! is its version and the CRC-32 of the program in the flash; `off` is the worst distance of an
//! edge in ticks of `hz`; `khz` is `hz` as measured by the chip's second clock, or `-` without one.

use core::fmt;

use crate::{Crc32, Found};

/// The version of the line's form that this crate writes and reads.
pub const FORMAT: u32 = 1;

/// The first word of a line.
pub const WORD: &str = "stepwright-selftest";

/// The content of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line<'a> {
    /// The chip's name.
    pub chip: &'a str,
    /// The firmware's version.
    pub version: &'a str,
    /// The CRC-32 of its program.
    pub flash: u32,
    /// The rate of the timer that stamps the edges.
    pub hz: u32,
    /// The results.
    pub found: Found,
    /// That rate as measured by the chip's second clock, in kHz.
    pub khz: Option<u32>,
}

/// Why a line can't be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineError<'a> {
    /// It does not begin with [`WORD`].
    Other,
    /// It has another version of the form.
    Format(u32),
    /// It ends before the word of this name, or has another word in its place.
    Missing(&'static str),
    /// The word of this name has an invalid value.
    Value(&'static str, &'a str),
    /// Its checksum is wrong: the stated one, and the computed one.
    Sum(u32, u32),
}

impl fmt::Display for LineError<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LineError::Other => {
                write!(f, "this is no line of a self-test: it begins with `{WORD}`")
            }
            LineError::Format(format) => {
                write!(f, "the line is of form {format}, and this command reads form {FORMAT}")
            }
            LineError::Missing(name) => {
                write!(
                    f,
                    "the line has no word `{name}=` where it should stand: a part of it is missing"
                )
            }
            LineError::Value(name, value) => write!(f, "`{name}={value}` is no number"),
            LineError::Sum(says, is) => write!(
                f,
                "the line was changed on its way: its checksum says {says:08x}, and it is {is:08x}"
            ),
        }
    }
}

impl core::error::Error for LineError<'_> {}

impl<'a> Line<'a> {
    /// Writes the line byte by byte, without an end of line.
    pub fn tell(&self, mut byte: impl FnMut(u8)) {
        let mut sum = Crc32::new();
        let mut say = |letter: u8| {
            sum.bytes(&[letter]);
            byte(letter);
        };
        let Found { orders, plan, steps, edges, off, late } = self.found;
        text(WORD, &mut say);
        word("format", FORMAT, &mut say);
        text(" chip=", &mut say);
        text(self.chip, &mut say);
        text(" firmware=", &mut say);
        text(self.version, &mut say);
        say(b'-');
        digits(self.flash, &mut say);
        word("hz", self.hz, &mut say);
        word("orders", orders, &mut say);
        text(" plan=", &mut say);
        digits(plan, &mut say);
        for (name, value) in [("steps", steps), ("edges", edges), ("off", off), ("late", late)] {
            word(name, value, &mut say);
        }
        match self.khz {
            Some(khz) => word("khz", khz, &mut say),
            None => text(" khz=-", &mut say),
        }
        text(" crc=", &mut byte);
        digits(sum.end(), &mut byte);
    }

    /// Reads a line.
    ///
    /// # Errors
    /// [`LineError`]. The checksum is checked last, so that a missing word is named.
    pub fn read(line: &'a str) -> Result<Line<'a>, LineError<'a>> {
        let line = line.trim();
        let mut words = Words(line.split(' '));
        if words.0.next() != Some(WORD) {
            return Err(LineError::Other);
        }
        let format = words.number("format")?;
        if format != FORMAT {
            return Err(LineError::Format(format));
        }
        let chip = words.value("chip")?;
        let firmware = words.value("firmware")?;
        let wrong = LineError::Value("firmware", firmware);
        let (version, flash) = firmware.rsplit_once('-').ok_or(wrong)?;
        let flash = hex(flash).ok_or(wrong)?;
        let hz = words.number("hz")?;
        let orders = words.number("orders")?;
        let plan = words.hex("plan")?;
        let (steps, edges) = (words.number("steps")?, words.number("edges")?);
        let (off, late) = (words.number("off")?, words.number("late")?);
        let khz = match words.value("khz")? {
            "-" => None,
            khz => Some(khz.parse().map_err(|_| LineError::Value("khz", khz))?),
        };
        let says = words.hex("crc")?;
        let mut sum = Crc32::new();
        let before = line.rsplit_once(" crc=").map_or(line, |(before, _)| before);
        sum.bytes(before.as_bytes());
        let is = sum.end();
        if says != is {
            return Err(LineError::Sum(says, is));
        }
        let found = Found { orders, plan, steps, edges, off, late };
        Ok(Line { chip, version, flash, hz, found, khz })
    }
}

/// The words of a line, one after another.
struct Words<'a>(core::str::Split<'a, char>);

impl<'a> Words<'a> {
    fn value(&mut self, name: &'static str) -> Result<&'a str, LineError<'a>> {
        let word = self.0.next().and_then(|word| word.strip_prefix(name)?.strip_prefix('='));
        word.filter(|value| !value.is_empty()).ok_or(LineError::Missing(name))
    }

    fn number(&mut self, name: &'static str) -> Result<u32, LineError<'a>> {
        let value = self.value(name)?;
        value.parse().map_err(|_| LineError::Value(name, value))
    }

    fn hex(&mut self, name: &'static str) -> Result<u32, LineError<'a>> {
        let value = self.value(name)?;
        hex(value).ok_or(LineError::Value(name, value))
    }
}

/// Parses eight hexadecimal digits.
fn hex(digits: &str) -> Option<u32> {
    let eight = digits.len() == 8 && digits.bytes().all(|digit| digit.is_ascii_hexdigit());
    u32::from_str_radix(digits, 16).ok().filter(|_| eight)
}

fn text(text: &str, byte: &mut impl FnMut(u8)) {
    text.bytes().for_each(byte);
}

fn word(name: &str, value: u32, byte: &mut impl FnMut(u8)) {
    byte(b' ');
    text(name, byte);
    byte(b'=');
    let mut unit = 1_000_000_000;
    while unit > 1 && unit > value {
        unit /= 10;
    }
    while unit > 0 {
        byte(b'0' + (value / unit % 10) as u8);
        unit /= 10;
    }
}

/// Writes eight hexadecimal digits.
fn digits(value: u32, byte: &mut impl FnMut(u8)) {
    for digit in value.to_be_bytes().into_iter().flat_map(|two| [two >> 4, two & 15]) {
        byte(if digit < 10 { b'0' + digit } else { b'a' - 10 + digit });
    }
}
