//! What things are called, and what they mean: the tables of the protocol.

use stepwright_protocol::{Ability, BoardError, Form, Refusal, Setting, Stop};

/// A table of words, by its number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum WordList {
    /// Names of settings.
    Setting,
    /// Their units.
    Unit,
    /// What they do.
    Help,
    /// Letters of stops.
    StopLetter,
    /// Names of stops.
    Stop,
    /// Stops for people: the end of "stopped by …".
    StopWords,
    /// Names of errors.
    Error,
    /// Errors for people.
    ErrorWords,
    /// Abilities.
    Ability,
    /// Refusals for people.
    Refusal,
    /// Names of refusals.
    RefusalName,
}

impl WordList {
    /// Every table, by its number.
    pub const ALL: [WordList; 11] = [
        WordList::Setting,
        WordList::Unit,
        WordList::Help,
        WordList::StopLetter,
        WordList::Stop,
        WordList::StopWords,
        WordList::Error,
        WordList::ErrorWords,
        WordList::Ability,
        WordList::Refusal,
        WordList::RefusalName,
    ];

    /// Its word at a place.
    pub fn word(self, place: usize) -> Option<&'static str> {
        let setting = || Setting::ALL.get(place);
        let stop = || Stop::ALL.get(place);
        Some(match self {
            WordList::Setting => setting()?.name(),
            WordList::Unit => setting()?.unit(),
            WordList::Help => setting()?.help(),
            WordList::StopLetter => letter(stop()?.letter()),
            WordList::Stop => stop()?.name(),
            WordList::StopWords => stop()?.words(),
            WordList::Error => BoardError::ALL.get(place)?.name(),
            WordList::ErrorWords => BoardError::ALL.get(place)?.words(),
            WordList::Ability => Ability::ALL.get(place)?.name(),
            WordList::Refusal => Refusal::ALL.get(place)?.words(),
            WordList::RefusalName => Refusal::ALL.get(place)?.name(),
        })
    }
}

/// A letter of a stop as a text.
fn letter(letter: u8) -> &'static str {
    let place = usize::from(letter.wrapping_sub(b'A'));
    "ABCDEFGHIJKLMNOPQRSTUVWXYZ".get(place..=place).unwrap_or("?")
}

/// What a line means, without its checksum.
pub fn meaning(line: &[u8]) -> &'static str {
    let bare = line.split(|byte| *byte == b'*').next().unwrap_or_default();
    match Form::of(bare) {
        _ if bare.is_empty() => "an empty line, to get in step",
        Some(form) => form.help(),
        None => "no line of the protocol",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_table_ends() {
        for list in WordList::ALL {
            let count = (0..100).take_while(|place| list.word(*place).is_some()).count();
            assert!((3..40).contains(&count), "{list:?}: {count}");
        }
        assert_eq!(WordList::StopLetter.word(0), Some("Z"));
        assert_eq!(WordList::StopLetter.word(8), Some("?"));
        assert!(meaning(b"G+4000*0B").starts_with("travel by this many steps"));
        assert_eq!(meaning(b"x"), "no line of the protocol");
    }
}
