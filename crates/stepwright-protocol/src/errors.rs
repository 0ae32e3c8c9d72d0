//! The errors of a board since they were last cleared: `errors=` in the answer to `?`.

use crate::flash::text;

/// Makes [`BoardError`] from the table.
macro_rules! errors {
    ($($error:ident $letter:literal, $name:literal, $words:literal, $doc:literal;)*) => {
        /// An error of a board. A letter of `errors=` in the answer to `?`, kept until `!`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum BoardError {
            $(#[doc = concat!("`", $letter, "`: ", $doc)] $error,)*
        }

        impl BoardError {
            /// Every error, in the order of the letters.
            pub const ALL: [BoardError; COUNT as usize] = [$(BoardError::$error),*];

            /// The name, for programs.
            pub const fn name(self) -> &'static str {
                match self { $(BoardError::$error => $name),* }
            }

            /// A description, for a person.
            pub const fn words(self) -> &'static str {
                match self { $(BoardError::$error => $words),* }
            }
        }

        /// The number of errors.
        pub(crate) const COUNT: u8 = [$($letter),*].len() as u8;

        /// The letter of this error, read from flash: it takes no RAM.
        fn letter(index: u8) -> Option<u8> {
            text!(concat!($($letter),*)).byte(index.into())
        }
    };
}

// The errors with the letters of `Stop` come first: they lock a board with `safe-start`.
errors! {
    Switch "S", "switch", "a limit switch", "a limit switch has stopped an axis.";
    Timeout "T", "timeout", "the silence of the host", "no line came for too long.";
    Kill "K", "kill", "a kill (K)", "the line K, whether or not an axis moved.";
    Emergency "E", "emergency", "the emergency stop", "the input of the emergency stop.";
    Driver "D", "driver", "a fault of a driver", "the fault input of a driver.";
    Reset "R", "reset", "a reset after motion", "a reset that has left a position unknown.";
    Late "l", "late", "late steps", "a step came late.";
    Sum "c", "sum", "a wrong checksum", "a line was not the one of its checksum.";
    Garbled "g", "garbled", "a damaged byte", "the receiver noticed a lost or damaged byte.";
}

/// The letter of [`BoardError::Sum`].
pub(crate) const SUM: u8 = b'c';
/// The letter of [`BoardError::Garbled`].
pub(crate) const GARBLED: u8 = b'g';

/// The bits of the errors that are stops: all below [`BoardError::Late`].
const STOPS: u16 = (1 << BoardError::Late as u8) - 1;

/// A set of errors.
///
/// ```
/// use stepwright_protocol::{BoardError, Errors};
/// let errors = Errors::parse(b"Tl");
/// assert_eq!(errors.iter().collect::<Vec<_>>(), [BoardError::Timeout, BoardError::Late]);
/// assert_eq!(Errors::parse(b"-"), Errors::NONE);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Errors(u16);

impl Errors {
    /// No errors.
    pub const NONE: Errors = Errors(0);

    /// Whether the set has this error.
    pub const fn has(self, error: BoardError) -> bool {
        self.0 >> error as u8 & 1 != 0
    }

    /// The set with this error added.
    pub const fn with(self, error: BoardError) -> Errors {
        Errors(self.0 | 1 << error as u8)
    }

    /// The errors of the set, in the order of the letters.
    pub fn iter(self) -> impl Iterator<Item = BoardError> {
        BoardError::ALL.into_iter().filter(move |error| self.has(*error))
    }

    /// Reads letters. Unknown letters, which a later version may send, are skipped, and so is `-`.
    pub fn parse(letters: &[u8]) -> Errors {
        let mut errors = Errors::NONE;
        for letter in letters {
            errors.note(*letter);
        }
        errors
    }

    /// Adds the error with this letter, if there is one.
    pub(crate) fn note(&mut self, this: u8) {
        let (mut index, mut bit) = (0u8, 1u16);
        while let Some(known) = letter(index) {
            if known == this {
                self.0 |= bit;
            }
            index = index.wrapping_add(1);
            bit <<= 1;
        }
    }

    /// Whether an axis was stopped, or a position lost.
    pub(crate) fn any_stop(self) -> bool {
        self.0 & STOPS != 0
    }

    /// The letter at this index, if the set has its error. `-` at index 0 of an empty set.
    pub(crate) fn letter(self, index: u8) -> Option<u8> {
        if self.0 == 0 && index == 0 {
            return Some(b'-');
        }
        letter(index).filter(|_| self.0.wrapping_shr(index.into()) & 1 != 0)
    }

    /// The letters, or `-`.
    pub(crate) fn letters(self) -> impl Iterator<Item = u8> + Clone {
        (0..COUNT).filter_map(move |index| self.letter(index))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::Stop;
    use proptest::prelude::*;

    pub(crate) fn any_errors() -> impl Strategy<Value = Errors> {
        (0..1u16 << COUNT).prop_map(Errors)
    }

    #[test]
    fn every_error_has_its_own_letter_and_a_stop_that_of_its_reason() {
        for (n, error) in (0..).zip(BoardError::ALL) {
            let own = letter(n).unwrap();
            assert_eq!(Errors::parse(&[own]), Errors::NONE.with(error));
            assert!(own.is_ascii_alphabetic());
        }
        assert_eq!(letter(COUNT), None);
        let stops = [Stop::Switch, Stop::Timeout, Stop::Kill, Stop::Emergency, Stop::Driver];
        for stop in stops.into_iter().chain([Stop::Reset]) {
            assert!(Errors::parse(&[stop.letter()]).any_stop(), "{stop:?}");
        }
        for letter in b"ZL-lcg?x" {
            assert!(!Errors::parse(&[*letter]).any_stop());
        }
    }

    proptest! {
        #[test]
        fn letters_are_read_back(errors in any_errors()) {
            let mut letters = [0; COUNT as usize];
            let mut count = 0;
            for letter in errors.letters() {
                letters[count] = letter;
                count += 1;
            }
            prop_assert_eq!(Errors::parse(&letters[..count]), errors);
            prop_assert!(count != 0);
        }
    }
}
