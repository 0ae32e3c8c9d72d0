//! A parsed line: its letter and its argument.

use crate::Refusal;
use crate::answer::setting_named;
use crate::grammar::{MILLI, ONE, RESET, Row, SET, flag};
use crate::number;
use crate::setting::Setting;

/// A line of the grammar, inside its ranges. The three plain numbers say what a
/// [`Command`](crate::Command) says in types: a chip that acts on them directly needs a quarter of
/// the flash.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RawLine {
    /// The line's letter, or [`ONE`], [`SET`] or [`RESET`].
    pub(crate) letter: u8,
    /// The conditions for taking it: bits of [`flag`].
    pub(crate) flags: u8,
    /// The sign after the letter: true for `-`.
    pub(crate) backward: bool,
    /// The setting that the line names.
    pub(crate) setting: Setting,
    /// The number at the end; a distance without its sign.
    pub(crate) number: u32,
}

impl RawLine {
    /// No line yet.
    pub(crate) const NOTHING: RawLine =
        RawLine { letter: 0, flags: 0, backward: false, setting: Setting::MaxSpeed, number: 0 };

    /// Reads a complete line, without its CR. An error leaves the letter unchanged.
    ///
    /// # Errors
    /// [`Refusal::Line`], [`Refusal::Range`], [`Refusal::Setting`] or [`Refusal::NoJerk`] for
    /// everything that is not exactly a line of the grammar.
    pub(crate) fn read(&mut self, line: &[u8]) -> Result<(), Refusal> {
        let Some((&letter, mut rest)) = line.split_first() else { return Err(Refusal::Line) };
        if letter == b'$' {
            return self.read_setting(rest);
        }
        let Some(row) = Row::of(letter) else { return Err(Refusal::Line) };
        let flags = row.flags();
        // `PO` is the only line of two letters.
        let second = if letter == b'P' { Some((b'O', b'0')) } else { None };
        let sign = if flags & flag::SIGN == 0 { second } else { Some((b'+', b'-')) };
        if let Some((one, other)) = sign {
            let Some((&sign, digits)) = rest.split_first() else { return Err(Refusal::Line) };
            if sign != one && sign != other {
                return Err(Refusal::Line);
            }
            self.backward = sign == b'-';
            rest = digits;
        } else {
            // Numbers without a sign have all 32 bits.
            self.backward = true;
        }
        if flags & flag::NUMBER != 0 {
            number::read(rest, &mut self.number)?;
            // Numbers with a sign are −2³¹ to 2³¹ − 1.
            if self.number > row.largest()
                || self.number >> 31 != 0 && !self.backward
                || (self.number == 0 && flags & flag::ZERO == 0)
            {
                return Err(Refusal::Range);
            }
        } else if !rest.is_empty() || flags & flag::SETTING != 0 {
            return Err(Refusal::Line);
        }
        if letter == b'j' && !cfg!(feature = "jerk") {
            return Err(Refusal::NoJerk);
        }
        self.flags = flags;
        self.letter = letter;
        Ok(())
    }

    /// Converts S to s, and T and t to m, with their units.
    pub(crate) fn unify(&mut self) {
        if matches!(self.letter, b'S' | b'T') {
            self.number = self.number.wrapping_mul(10);
            self.letter |= b's' ^ b'S';
        }
        if self.letter == b't' {
            self.number = self.number.wrapping_mul(1000);
            self.letter = MILLI;
        }
    }

    /// The distance with its sign.
    pub(crate) fn steps(&self) -> i32 {
        let steps = self.number as i32;
        if self.backward { steps.wrapping_neg() } else { steps }
    }

    /// Reads the text after a `$`: `name=number`, `name` alone, `reset` or nothing.
    pub(crate) fn read_setting(&mut self, text: &[u8]) -> Result<(), Refusal> {
        let sign = text.iter().position(|byte| *byte == b'=').unwrap_or(text.len());
        let (name, number) = text.split_at_checked(sign).unwrap_or_default();
        let mut letter = if text.is_empty() { b'$' } else { ONE };
        if letter == ONE {
            let index = setting_named(name).ok_or(Refusal::Setting)?;
            if let Some(setting) = Setting::numbered(index) {
                self.setting = setting;
            } else if number.is_empty() {
                letter = RESET;
            } else {
                return Err(Refusal::Setting);
            }
        }
        if let Some((_, number)) = number.split_first() {
            number::read(number, &mut self.number)?;
            if !self.setting.allows(self.number) {
                return Err(Refusal::Range);
            }
            letter = SET;
        }
        self.letter = letter;
        self.flags = Row::of(letter).map_or(0, Row::flags);
        Ok(())
    }
}
