//! The grammar of the line, read by a second parser.
//!
//! It shares no code with the parser of the boards: it works on text with numbers of 128 bits, and follows
//! the table in the documentation of the protocol's crate.

use crate::reason::{Reason, Reasons};
use crate::settings::{self, Name};
use crate::story::Can;

/// The longest accepted line in bytes, without its CR.
pub const LONGEST: usize = 24;

/// A parsed line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// `PO`, `P0`.
    Program,
    /// `S`, `T`, `R`, `s`, `m`, `a`, `d`, `j` and a number; `t` is `m` in thousandths.
    Manner(u8, u32),
    /// `G` and a distance.
    Go(i64),
    /// `@` and a distance.
    Retarget(i64),
    /// `g`: forward or not.
    Run(bool),
    /// `E`.
    Execute,
    /// `F`.
    Status,
    /// `Z`.
    Brake,
    /// `K`.
    Kill,
    /// `I` and an axis.
    Zero(u8),
    /// `V` and an axis.
    Position(u8),
    /// `A` and an axis, or 0.
    Select(u8),
    /// `?`.
    Info,
    /// `L` and a time in ms.
    Lease(u32),
    /// `!`.
    Clear,
    /// `$`.
    All,
    /// `$name`.
    Get(Name),
    /// `$name=number`.
    Set(Name, u32),
    /// `$reset`.
    Reset,
}

/// Reads a line without its CR. LF bytes before and after it have been skipped. `can` is what the board
/// supports.
///
/// # Errors
/// The reasons for a refusal that a board may give.
pub fn read(line: &[u8], can: Can) -> Result<Line, Reasons> {
    let bad = Err(Reason::Line.into());
    if line.len() > LONGEST {
        return bad;
    }
    let Some((&letter, rest)) = line.split_first() else { return bad };
    let plain = |line: Line| if rest.is_empty() { Ok(line) } else { bad };
    match letter {
        b'P' if rest == b"O" || rest == b"0" => Ok(Line::Program),
        b'S' | b'T' | b'R' => Ok(Line::Manner(letter, number(rest, 1, 999)?)),
        b's' => Ok(Line::Manner(letter, number(rest, 0, 1_000_000)?)),
        // One speed, in 0.001 steps/s.
        b't' => Ok(Line::Manner(b'm', number(rest, 1, 1_000_000)? * 1000)),
        b'm' => Ok(Line::Manner(b'm', number(rest, 1, 1_000_000_000)?)),
        b'a' | b'd' => Ok(Line::Manner(letter, number(rest, 1, 100_000_000)?)),
        b'j' if can.jerk => Ok(Line::Manner(letter, number(rest, 0, 4_000_000_000)?)),
        // A damaged line is no line, on any board.
        b'j' => Err(number(rest, 0, 4_000_000_000).err().unwrap_or(Reason::NoJerk.into())),
        b'G' | b'@' => {
            let Some((sign, digits)) = rest.split_first() else { return bad };
            let steps = match sign {
                b'+' => i64::from(number(digits, 0, 0x7FFF_FFFF)?),
                b'-' => -i64::from(number(digits, 0, 0x8000_0000)?),
                _ => return bad,
            };
            Ok(if letter == b'G' { Line::Go(steps) } else { Line::Retarget(steps) })
        }
        b'g' if rest == b"+" || rest == b"-" => Ok(Line::Run(rest == b"+")),
        b'E' => plain(Line::Execute),
        b'F' => plain(Line::Status),
        b'Z' => plain(Line::Brake),
        b'K' => plain(Line::Kill),
        b'I' => Ok(Line::Zero(number(rest, 1, 8)? as u8)),
        b'V' => Ok(Line::Position(number(rest, 1, 8)? as u8)),
        b'A' => Ok(Line::Select(number(rest, 0, 8)? as u8)),
        b'L' => Ok(Line::Lease(number(rest, 0, 60_000)?)),
        b'?' => plain(Line::Info),
        b'!' => plain(Line::Clear),
        b'$' => setting(rest, can),
        _ => bad,
    }
}

/// Reads a number of digits only.
fn number(digits: &[u8], least: u32, most: u32) -> Result<u32, Reasons> {
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return Err(Reason::Line.into());
    }
    // At most 24 digits, which fit in 128 bits.
    let number = digits.iter().fold(0u128, |sum, digit| sum * 10 + u128::from(digit - b'0'));
    match u32::try_from(number) {
        Ok(number) if (least..=most).contains(&number) => Ok(number),
        _ => Err(Reason::Range.into()),
    }
}

/// Reads the text after a `$`.
fn setting(text: &[u8], can: Can) -> Result<Line, Reasons> {
    let text = core::str::from_utf8(text).map_err(|_| Reason::Setting | Reason::Line)?;
    if text.is_empty() {
        return Ok(Line::All);
    }
    let Some((name, digits)) = text.split_once('=') else {
        return match text {
            "reset" => Ok(Line::Reset),
            name => settings::named(name, can).map(Line::Get).ok_or(Reason::Setting.into()),
        };
    };
    let name = settings::named(name, can).ok_or(Reasons::from(Reason::Setting))?;
    let (least, most) = name.range();
    number(digits.as_bytes(), least, most).map(|number| Line::Set(name, number))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Can = Can { jerk: true };
    const NONE: Can = Can { jerk: false };

    #[test]
    fn the_table_of_the_grammar() {
        let ok = |line: &str| read(line.as_bytes(), ALL).unwrap();
        assert_eq!(ok("PO"), Line::Program);
        assert_eq!(ok("P0"), Line::Program);
        assert_eq!(ok("S0005"), Line::Manner(b'S', 5));
        assert_eq!(ok("G-2147483648"), Line::Go(-2_147_483_648));
        assert_eq!(ok("@-0"), Line::Retarget(0));
        assert_eq!(ok("@-2147483648"), Line::Retarget(-2_147_483_648));
        assert_eq!(ok("g-"), Line::Run(false));
        assert_eq!(ok("A0"), Line::Select(0));
        assert_eq!(ok("j4000000000"), Line::Manner(b'j', 4_000_000_000));
        assert!(matches!(ok("$pulse-us=20"), Line::Set(_, 20)));
        assert_eq!(ok("L60000"), Line::Lease(60_000));
    }

    #[test]
    fn what_is_no_line() {
        let why = |line: &str| read(line.as_bytes(), ALL).unwrap_err();
        for line in ["", "po", "G5", "G+", "G+-5", "S 5", "PO1", "g", "F0", "V", "é"] {
            assert_eq!(why(line), Reason::Line.into(), "{line}");
        }
        for line in [
            "S0",
            "S1000",
            "t0",
            "G+2147483648",
            "G-2147483649",
            "@-2147483649",
            "V9",
            "I0",
            "$pulse-us=21",
        ] {
            assert_eq!(why(line), Reason::Range.into(), "{line}");
        }
        assert_eq!(why("$pulse"), Reason::Setting.into());
        assert_eq!(read(b"j5", NONE).unwrap_err(), Reason::NoJerk.into());
        assert_eq!(read(b"jA+m", NONE).unwrap_err(), Reason::Line.into());
        assert_eq!(why("t0000000000000000000000001"), Reason::Line.into());
    }
}
