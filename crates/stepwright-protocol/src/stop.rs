//! The reasons why an axis has stopped before the end of its order.

use crate::axis::{AxisId, MAX_AXES};

/// Makes [`Stop`] from the table.
macro_rules! stops {
    ($($stop:ident $letter:literal, $name:literal, $words:literal, $doc:literal;)*) => {
        /// The reason of a stop that an order did not ask for. A letter of `stop=` in the answer to
        /// `?`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum Stop {
            $(#[doc = $doc] $stop = $letter,)*
        }

        impl Stop {
            /// Every reason.
            pub const ALL: [Stop; [$($letter),*].len()] = [$(Stop::$stop),*];

            /// The name, for programs.
            pub const fn name(self) -> &'static str {
                match self { $(Stop::$stop => $name),* }
            }

            /// A description for a person: the end of "stopped by …".
            pub const fn words(self) -> &'static str {
                match self { $(Stop::$stop => $words),* }
            }
        }
    };
}

stops! {
    Soft b'Z', "stop", "a soft stop (Z)", "`Z`: the line Z; a ramp down.";
    Kill b'K', "kill", "a kill (K)", "`K`: the line K; the position is lost.";
    Switch b'S', "switch", "its limit switch", "`S`: a closed limit switch.";
    Timeout b'T', "timeout", "the silence of the host", "`T`: no line came for too long; a ramp down.";
    Emergency b'E', "emergency", "the emergency stop", "`E`: the input of the emergency stop.";
    Driver b'D', "driver", "a fault of its driver", "`D`: the fault input of a driver.";
    Reset b'R', "reset", "a reset of the board", "`R`: the board began again while the axis moved.";
    Limit b'L', "limit", "its soft limit", "`L`: the end of the range in the settings; a ramp down.";
    Other b'?', "other", "a reason that this version has no word for", "`?`: a letter of a later version.";
}

impl Stop {
    /// The letter on the line.
    pub const fn letter(self) -> u8 {
        self as u8
    }

    /// The reason with this letter; `None` for `-`.
    fn of(letter: u8) -> Option<Stop> {
        let known = Stop::ALL.into_iter().find(|stop| stop.letter() == letter);
        (letter != NONE).then_some(known.unwrap_or(Stop::Other))
    }
}

/// The letter of an axis that was not stopped.
pub(crate) const NONE: u8 = b'-';

/// Whether the axis with this letter ramps down: Z and T, which are above the other letters.
pub(crate) fn is_soft(letter: u8) -> bool {
    letter >= b'T'
}

/// Why each axis of a board has stopped.
///
/// ```
/// use stepwright_protocol::{AxisId, Stop, Stops};
/// let stops = Stops::parse(b"-ZS").unwrap();
/// let reasons: Vec<_> = AxisId::first(3).map(|axis| stops.of(axis)).collect();
/// assert_eq!(reasons, [None, Some(Stop::Soft), Some(Stop::Switch)]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stops {
    letters: [u8; MAX_AXES as usize],
    axes: u8,
}

impl Stops {
    /// Why this axis has stopped; `None` if its last travel ended as ordered, or is still under
    /// way.
    pub fn of(&self, axis: AxisId) -> Option<Stop> {
        self.letters.get(axis.index()).and_then(|letter| Stop::of(*letter))
    }

    /// Reads the letters, one per axis: 1 … 8 of them.
    pub fn parse(letters: &[u8]) -> Option<Stops> {
        let mut stops = Stops { letters: [NONE; MAX_AXES as usize], axes: letters.len() as u8 };
        stops.letters.get_mut(..letters.len())?.copy_from_slice(letters);
        (!letters.is_empty()).then_some(stops)
    }

    /// The letters, one per axis.
    pub fn letters(&self) -> &[u8] {
        self.letters.get(..usize::from(self.axes)).unwrap_or_default()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;

    pub(crate) fn any_stops() -> impl Strategy<Value = Stops> {
        let letters = Stop::ALL.map(Stop::letter);
        proptest::collection::vec(proptest::sample::select(letters.to_vec()), 1..=8)
            .prop_map(|letters| Stops::parse(&letters).unwrap())
    }

    #[test]
    fn every_letter_is_its_own_and_none_is_a_sign_of_the_line() {
        for stop in Stop::ALL {
            assert_eq!(Stop::of(stop.letter()), Some(stop));
            assert!(!b"-\r\n *,=".contains(&stop.letter()));
            assert_eq!(is_soft(stop.letter()), matches!(stop, Stop::Soft | Stop::Timeout));
        }
        assert_eq!((Stop::of(b'-'), Stop::of(b'Q')), (None, Some(Stop::Other)));
    }

    #[test]
    fn there_is_a_letter_for_each_of_at_most_eight_axes() {
        assert_eq!(Stops::parse(b"ZKSTEDRL").unwrap().letters(), b"ZKSTEDRL");
        assert_eq!((Stops::parse(b""), Stops::parse(b"---------")), (None, None));
    }
}
