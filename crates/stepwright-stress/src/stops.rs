//! Why an axis stopped before the end of its order: the letters of `stop=`.

use crate::track::Known;

/// The letters that a board may show for an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stops(u16);

/// The letters in the order of the bits.
const LETTERS: &[u8] = b"-ZTKSRED";

impl Stops {
    /// The axis moved as ordered.
    pub const NONE: Stops = Stops(1);

    fn of(letter: u8) -> Stops {
        let bit = LETTERS.iter().position(|known| *known == letter);
        Stops(bit.map_or(0, |bit| 1 << bit))
    }

    /// Whether the letter is possible. If so, it becomes the only possible one.
    pub fn are(&mut self, letter: u8) -> bool {
        let one = Stops::of(letter);
        let fits = self.0 & one.0 != 0;
        if fits {
            *self = one;
        }
        fits
    }

    /// Whether this is the only possible letter.
    pub fn says(self, letter: u8) -> bool {
        self == Stops::of(letter)
    }

    /// Notes a stop at once of an axis that may be busy.
    pub fn hard(&mut self, letter: u8, busy: Known) {
        match busy {
            Known::Yes => *self = Stops::of(letter),
            Known::Maybe => self.0 |= Stops::of(letter).0,
            Known::No => {}
        }
    }

    /// Notes a stop along the ramp. The first of two is kept.
    pub fn soft(&mut self, letter: u8, busy: Known) {
        let soft = Stops::of(b'Z').0 | Stops::of(b'T').0;
        let kept = Stops(self.0 & soft);
        if self.0 & !soft != 0 {
            self.hard(letter, busy);
            self.0 |= kept.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_two_soft_stops_is_kept_and_a_hard_one_replaces_it() {
        let mut stops = Stops::NONE;
        stops.soft(b'Z', Known::Yes);
        stops.soft(b'T', Known::Yes);
        assert!(!stops.are(b'T') && stops.are(b'Z'));
        stops.hard(b'K', Known::Maybe);
        assert!(stops.are(b'K') && !stops.are(b'Z'));
        stops.hard(b'S', Known::No);
        assert!(!stops.are(b'S') && !stops.are(b'?'));
    }
}
