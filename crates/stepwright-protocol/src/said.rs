//! A line taken apart: its letter, and what stands behind it.

use crate::answer::setting_named;
#[cfg(feature = "safety")]
use crate::number::LeaseMillis;
#[cfg(feature = "s-curve")]
use crate::number::WholeJerk;
use crate::number::{self, RampSteps, TopSpeed, WholeAccel};
use crate::setting::Setting;
use crate::{MAX_AXES, Refusal};

/// A line of the grammar, inside its ranges. What a [`Command`](crate::Command)
/// says in types is here in three plain numbers: a chip that acts upon them at
/// once needs a quarter of the flash.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Said {
    /// The line's letter, or one of the three below.
    pub(crate) letter: u8,
    /// The sign behind it: true for `-`.
    pub(crate) backward: bool,
    /// The setting that is named.
    pub(crate) setting: Setting,
    /// The number at the end; a distance without its sign.
    pub(crate) number: u32,
}

/// For the letter of `$name`.
pub(crate) const ONE: u8 = b'n';
/// For the letter of `$name=number`.
pub(crate) const SET: u8 = b'=';
/// For the letter of `$reset`.
pub(crate) const RESET: u8 = b'r';

impl Said {
    /// No line yet.
    pub(crate) const NOTHING: Said =
        Said { letter: 0, backward: false, setting: Setting::MaxSpeed, number: 0 };

    /// Reads a complete line, without its CR. After an error the letter is
    /// what it was.
    ///
    /// # Errors
    /// [`Refusal::Line`], [`Refusal::Range`], [`Refusal::Setting`] or [`Refusal::NoJerk`] for
    /// everything that is not exactly a line of the grammar.
    pub(crate) fn read(&mut self, line: &[u8]) -> Result<(), Refusal> {
        let Some((&letter, mut rest)) = line.split_first() else { return Err(Refusal::Line) };
        let largest = match letter {
            b'$' => return self.read_setting(rest),
            b'S' | b'T' | b'R' => RampSteps::LARGEST.get(),
            b's' | b't' => TopSpeed::LARGEST.get(),
            b'a' | b'd' => WholeAccel::LARGEST.get(),
            #[cfg(feature = "s-curve")]
            b'j' => WholeJerk::LARGEST.get(),
            #[cfg(not(feature = "s-curve"))]
            b'j' => return Err(Refusal::NoJerk),
            #[cfg(feature = "safety")]
            b'L' => LeaseMillis::LARGEST.get(),
            b'I' | b'V' | b'A' => MAX_AXES as u32,
            b'G' | b'@' => i32::MAX as u32,
            b'E' | b'F' | b'Z' | b'K' | b'?' | b'!' | b'P' | b'g' => 0,
            _ => return Err(Refusal::Line),
        };
        if matches!(letter, b'G' | b'g' | b'P' | b'@') {
            let Some((&sign, digits)) = rest.split_first() else { return Err(Refusal::Line) };
            let (one, other) = if letter == b'P' { (b'O', b'0') } else { (b'+', b'-') };
            if sign != one && sign != other {
                return Err(Refusal::Line);
            }
            self.backward = sign == b'-';
            rest = digits;
        }
        if largest != 0 {
            number::read(rest, &mut self.number)?;
            let zero = matches!(letter, b's' | b'A' | b'G' | b'@')
                || cfg!(feature = "s-curve") && letter == b'j'
                || cfg!(feature = "safety") && letter == b'L';
            if self.number > largest || (self.number == 0 && !zero) {
                return Err(Refusal::Range);
            }
        } else if !rest.is_empty() {
            return Err(Refusal::Line);
        }
        self.letter = letter;
        Ok(())
    }

    /// The distance that it names.
    pub(crate) fn steps(&self) -> i32 {
        let steps = self.number as i32;
        if self.backward { steps.wrapping_neg() } else { steps }
    }

    /// What stands behind a `$`: `name=number`, `name` alone, `reset` or
    /// nothing.
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
        Ok(())
    }
}
