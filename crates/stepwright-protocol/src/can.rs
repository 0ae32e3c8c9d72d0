//! The abilities of a board: the words of `can=` in the answer to `?`.

/// Makes [`Ability`] from the table.
macro_rules! abilities {
    ($($ability:ident, $here:expr, $word:literal, $doc:literal;)*) => {
        /// An ability that some boards have and others have no room for.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum Ability {
            $(#[doc = concat!("`", $word, "`: ", $doc)] $ability,)*
        }

        impl Ability {
            /// Every ability, in the order of the words.
            pub const ALL: [Ability; [$($word),*].len()] = [$(Ability::$ability),*];

            /// The word on the line.
            pub const fn name(self) -> &'static str {
                match self { $(Ability::$ability => $word),* }
            }
        }

        impl Abilities {
            /// The abilities of this build.
            pub const OWN: Abilities =
                Abilities(0 $(| ($here as u8) << Ability::$ability as u8)*);
        }
    };
}

abilities! {
    Jerk, cfg!(feature = "jerk"), "jerk",
        "`j` limits the jerk of an order (S-curves)";
    Safety, true, "safety",
        "the settings and answers that guard a machine";
    Sum, true, "sum",
        "a line with a checksum is checked, and answered with one";
    Laser, false, "laser",
        "a streamed run has the power of a laser";
}

/// A set of abilities.
///
/// ```
/// use stepwright_protocol::{Abilities, Ability};
/// let can = Abilities::parse(b"jerk,later");
/// assert!(can.has(Ability::Jerk) && !can.has(Ability::Safety));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Abilities(u8);

impl Abilities {
    /// No abilities.
    pub const NONE: Abilities = Abilities(0);

    /// Whether the set has this ability.
    pub const fn has(self, ability: Ability) -> bool {
        self.0 & 1 << ability as u8 != 0
    }

    /// The set with this ability added.
    pub const fn with(self, ability: Ability) -> Abilities {
        Abilities(self.0 | 1 << ability as u8)
    }

    /// Reads words separated by commas. Unknown words, which a later version may send, are skipped,
    /// and so is `none`.
    pub fn parse(words: &[u8]) -> Abilities {
        let mut can = Abilities::NONE;
        for word in words.split(|byte| *byte == b',') {
            for ability in Ability::ALL {
                if ability.name().as_bytes() == word {
                    can = can.with(ability);
                }
            }
        }
        can
    }

    /// `can=` and the words, or `none`, filled up to this length with ends of line, at least one.
    const fn padded(self) -> [u8; LONGEST] {
        let mut line = [b'\n'; LONGEST];
        let mut to = write(&mut line, 0, "can=");
        if self.0 == 0 {
            write(&mut line, to, "none");
        }
        let (mut n, mut first) = (0, true);
        while n < Ability::ALL.len() {
            let ability = Ability::ALL[n];
            if self.has(ability) {
                to = if first { to } else { write(&mut line, to, ",") };
                to = write(&mut line, to, ability.name());
                first = false;
            }
            n += 1;
        }
        line
    }

    /// `can=` and the words, or `none`.
    pub(crate) fn line(self) -> impl Iterator<Item = u8> + Clone {
        self.padded().into_iter().take_while(|byte| *byte != b'\n')
    }
}

/// The line of the answers' text with the abilities of this build.
pub(crate) const LINE: &[u8] = OWN.split_at(length(OWN)).0;
const OWN: &[u8] = &Abilities::OWN.padded();

/// More than the length of all words with their commas.
const LONGEST: usize = 64;

const fn write(line: &mut [u8; LONGEST], from: usize, word: &str) -> usize {
    let mut at = 0;
    while at < word.len() {
        line[from + at] = word.as_bytes()[at];
        at += 1;
    }
    from + at
}

/// The length up to and including the first end of line.
const fn length(line: &[u8]) -> usize {
    let mut at = 0;
    while line[at] != b'\n' {
        at += 1;
    }
    at + 1
}

#[cfg(test)]
pub(crate) mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::string::String;
    use std::vec::Vec;

    pub(crate) fn any_abilities() -> impl Strategy<Value = Abilities> {
        proptest::collection::vec(proptest::sample::select(&Ability::ALL[..]), 0..4)
            .prop_map(|list| list.into_iter().fold(Abilities::NONE, Abilities::with))
    }

    fn text(can: Abilities) -> String {
        String::from_utf8(can.line().collect::<Vec<u8>>()).unwrap()
    }

    #[test]
    fn words_are_written_and_read_back() {
        assert_eq!(text(Abilities::NONE), "can=none");
        assert_eq!(text(Abilities::NONE.with(Ability::Safety)), "can=safety");
        let all = Ability::ALL.into_iter().fold(Abilities::NONE, Abilities::with);
        assert!(text(all).len() < LONGEST && text(all).starts_with("can=jerk,safety"));
        for can in (0..=all.0).map(Abilities) {
            assert_eq!(Abilities::parse(&text(can).as_bytes()[4..]), can);
        }
    }

    #[test]
    fn only_whole_words_count_and_later_ones_are_skipped() {
        let jerk = Abilities::NONE.with(Ability::Jerk);
        assert_eq!(Abilities::parse(b"fly,jerk,safetynet,,saf"), jerk);
        assert_eq!(Abilities::parse(b""), Abilities::NONE);
    }

    #[test]
    fn the_line_of_this_build_is_in_the_text() {
        assert_eq!(LINE, std::format!("{}\n", text(Abilities::OWN)).as_bytes());
    }
}
