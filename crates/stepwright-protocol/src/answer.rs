//! The slave's answers, sent a byte at a time.
//!
//! All answers are in one text in flash, line by line. A `#` in it stands for a number, which is
//! requested only when it is due. So an answer takes no more RAM than the digits of one number: at
//! 115200 baud a byte takes 87 µs, and a board that wrote the longest answer in one go would block
//! for 35 ms or need 400 bytes of RAM. `core::fmt` is not used; on an AVR it alone would fill
//! several kilobytes of flash.

use crate::can;
use crate::flash::{Text, flash};
use crate::machine::REASONS;
use crate::setting::{NAMES, Setting};
use crate::text::Decimal;

/// All answers, then the words of `last=`.
const LINES: &[&[u8]] = &[
    b"Y\nE\nR\nB\n#\nstepwright #.# axes=# max=# late=# refused=# last=# uncertain=#\n",
    b"stop=########\n",
    b"errors=#########\n",
    can::LINE,
    b"closed=#\n",
    NAMES,
    // Not an answer; [`setting_named`] looks for it among the names.
    b"reset=#\n",
    REASONS.as_bytes(),
];
const LENGTH: usize = length();
const TEXT: Text = flash!(LENGTH, joined());

const fn length() -> usize {
    let (mut length, mut line) = (0, 0);
    while line < LINES.len() {
        length += LINES[line].len();
        line += 1;
    }
    length
}

const fn joined() -> [u8; LENGTH] {
    let mut bytes = [0; LENGTH];
    let (mut to, mut line) = (0, 0);
    while line < LINES.len() {
        let mut at = 0;
        while at < LINES[line].len() {
            bytes[to] = LINES[line][at];
            to += 1;
            at += 1;
        }
        line += 1;
    }
    bytes
}

/// Line numbers of the text.
pub(crate) mod line {
    pub(crate) const YES: u8 = 0;
    pub(crate) const NO: u8 = 1;
    pub(crate) const READY: u8 = 2;
    pub(crate) const BUSY: u8 = 3;
    pub(crate) const POSITION: u8 = 4;
    /// With the lines after it: `stop=`, `errors=`, `can=` and `closed=`.
    pub(crate) const INFO: u8 = 5;
    /// The first setting.
    pub(crate) const SETTINGS: u8 = 10;
    /// `none`; the reasons follow.
    pub(crate) const REASONS: u8 = SETTINGS + super::RESET + 1;
}

/// The numbers of the values that the `#` stand for.
pub(crate) mod value {
    pub(crate) const POSITION: u8 = 0;
    pub(crate) const MAJOR: u8 = 1;
    pub(crate) const MINOR: u8 = 2;
    pub(crate) const AXES: u8 = 3;
    pub(crate) const MAX: u8 = 4;
    pub(crate) const LATE: u8 = 5;
    pub(crate) const REFUSED: u8 = 6;
    /// A word, not a number.
    pub(crate) const LAST: u8 = 7;
    pub(crate) const UNCERTAIN: u8 = 8;
    /// The letter of the first of eight axes.
    pub(crate) const STOPS: u8 = 9;
    /// The letter of the first of the errors.
    pub(crate) const ERRORS: u8 = 17;
    pub(crate) const CLOSED: u8 = ERRORS + crate::errors::COUNT;
    /// The first setting.
    pub(crate) const SETTINGS: u8 = CLOSED + 1;
}

/// The digits are set; no byte precedes them.
pub(crate) const DIGITS: u8 = 0;
/// There is no such value.
pub(crate) const NOTHING: u8 = 1;

/// An answer: the part that is not sent yet.
#[derive(Clone, Debug)]
pub(crate) struct Answer {
    /// The position in the text.
    at: u16,
    /// The position after the word of `last=`; 0 while no such word is being sent.
    after: u16,
    /// The number of the next `#`.
    value: u8,
    /// The lines of the text that are still to be sent, with spaces between them.
    lines: u8,
    number: Decimal,
}

impl Answer {
    /// Nothing to send.
    pub(crate) const NONE: Answer =
        Answer { at: 0, after: 0, value: 0, lines: 0, number: Decimal::NONE };

    /// Begins an answer of this many lines of the text.
    pub(crate) fn begin(&mut self, first: u8, lines: u8) {
        (self.at, self.value) = find(first);
        self.lines = lines;
    }

    /// Whether bytes are still to be sent.
    pub(crate) fn is_left(&self) -> bool {
        self.lines != 0
    }

    /// The next byte. When value `n` is due, `number` sets its digits and returns [`DIGITS`], or
    /// the byte to send before them or for the value, or [`NOTHING`]. `last` is the word of
    /// `last=`: 0 for `none`, else 1 more than the reason.
    pub(crate) fn next(
        &mut self,
        last: u8,
        mut number: impl FnMut(u8, &mut Decimal) -> u8,
    ) -> Option<u8> {
        let digit = self.number.next();
        if digit.is_some() {
            return digit;
        }
        while self.lines != 0 {
            let byte = TEXT.byte(self.at)?;
            self.at = self.at.wrapping_add(1);
            match byte {
                b'#' => {
                    let value = self.value;
                    self.value = value.wrapping_add(1);
                    if value == value::LAST {
                        self.after = self.at;
                        (self.at, _) = find(line::REASONS.wrapping_add(last));
                        continue;
                    }
                    match number(value, &mut self.number) {
                        DIGITS => return self.number.next(),
                        NOTHING => continue,
                        byte => return Some(byte),
                    }
                }
                b'\n' if self.after != 0 => self.at = core::mem::take(&mut self.after),
                b'\n' => {
                    self.lines = self.lines.wrapping_sub(1);
                    return Some(if self.lines == 0 { b'\r' } else { b' ' });
                }
                _ => return Some(byte),
            }
        }
        None
    }
}

/// The position where a line begins, and the number of its first `#`.
#[inline(never)]
fn find(line: u8) -> (u16, u8) {
    let (mut at, mut left, mut value) = (0u16, line, 0u8);
    while left != 0
        && let Some(byte) = TEXT.byte(at)
    {
        at = at.wrapping_add(1);
        if byte == b'\n' {
            left = left.wrapping_sub(1);
        } else if byte == b'#' {
            value = value.wrapping_add(1);
        }
    }
    (at, value)
}

/// The index of `reset`.
pub(crate) const RESET: u8 = Setting::COUNT as u8;

/// The index of the setting with this name, or [`RESET`]. No name contains `=`.
#[inline(never)]
pub(crate) fn setting_named(name: &[u8]) -> Option<u8> {
    let (mut at, _) = find(line::SETTINGS);
    for index in 0..=RESET {
        let (mut length, mut same) = (0usize, true);
        loop {
            let byte = TEXT.byte(at)?;
            at = at.wrapping_add(1);
            if byte == b'=' {
                break;
            }
            same &= name.get(length) == Some(&byte);
            length = length.wrapping_add(1);
        }
        if same && length == name.len() {
            return Some(index);
        }
        // Skips the `#` and the end of the line.
        at = at.wrapping_add(2);
    }
    None
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::Refusal;
    use std::string::String;

    fn raw(first: u8, lines: u8, number: impl Fn(u8) -> i64) -> String {
        let mut answer = Answer::NONE;
        answer.begin(first, lines);
        let last = number(value::LAST) as u8;
        let set = |value, digits: &mut Decimal| {
            if (value::STOPS..value::SETTINGS).contains(&value) {
                return if value < value::STOPS + 3 {
                    b'a' + value - value::STOPS
                } else {
                    NOTHING
                };
            }
            digits.set(&mut number(value).unsigned_abs().to_le_bytes());
            if number(value) < 0 { b'-' } else { DIGITS }
        };
        let text = core::iter::from_fn(|| answer.next(last, set)).map(char::from).collect();
        assert!(!answer.is_left());
        text
    }

    #[test]
    fn every_line_has_its_number() {
        let own = |n| i64::from(n) - 1;
        for (line, text) in
            [(line::YES, "Y\r"), (line::NO, "E\r"), (line::READY, "R\r"), (line::BUSY, "B\r")]
        {
            assert_eq!(raw(line, 1, own), text);
        }
        assert_eq!(raw(line::POSITION, 1, own), "-1\r");
        assert_eq!(raw(line::POSITION, 1, |_| i64::MIN), "-9223372036854775808\r");
        assert_eq!(
            raw(line::INFO, 2, own),
            "stepwright 0.1 axes=2 max=3 late=4 refused=5 last=busy uncertain=7 stop=abc\r"
        );
        let first = value::SETTINGS - 1;
        let two = std::format!("max-speed={first} max-accel={}\r", first + 1);
        assert_eq!(raw(line::SETTINGS, 2, own), two);
        for setting in Setting::ALL {
            let text = raw(line::SETTINGS + setting as u8, 1, own);
            let number = value::SETTINGS + setting as u8 - 1;
            assert_eq!(text, std::format!("{}={number}\r", setting.name()));
            assert_eq!(setting_named(setting.name().as_bytes()), Some(setting as u8));
        }
    }

    #[test]
    fn every_reason_has_its_word() {
        let word = |n: i64| {
            let text = raw(line::INFO, 1, |value| if value == value::LAST { n } else { 0 });
            let (_, word) = text.split_once("last=").unwrap();
            String::from(word.split_once(' ').unwrap().0)
        };
        assert_eq!(word(0), "none");
        for refusal in Refusal::ALL {
            assert_eq!(word(refusal as i64 + 1), refusal.name());
        }
    }

    #[test]
    fn only_a_whole_name_is_a_name() {
        for name in
            [&b""[..], b"max", b"max-spee", b"max-speedy", b"max-speed=", b"#", b"\n", b"none"]
        {
            assert_eq!(setting_named(name), None, "{name:?}");
        }
        assert_eq!(setting_named(b"reset"), Some(RESET));
    }
}
