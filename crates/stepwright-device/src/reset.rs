//! What a board knows of its position when it begins.
//!
//! A reset forgets the position, and says nothing of it: the board counts from 0
//! again. That is true of a board that has just been switched on, and of one that
//! has not moved since. So a board keeps a [`Mark`] in RAM that no start-up code
//! clears, where it outlasts every reset but a loss of power, and holds that against
//! the reason of the reset:
//!
//! | the reset was | no mark | moved | moving |
//! | --- | --- | --- | --- |
//! | power-up | known | known | unknown |
//! | the button's, a brown-out, not told | known | unknown | unknown |
//! | the watchdog's | unknown | unknown | unknown |
//!
//! Many boot loaders clear the register that tells the reason (MCUSR): then the mark
//! alone decides. RAM keeps its contents for some seconds without power, so a board
//! of that kind that is unplugged for a moment doubts as well. After a longer loss of
//! power no mark is left, in motion or not: 0 is where the axes stand at power-up.
//! A chip that does not tell a brown-out from power-up (RP2040, nRF51) says power-up.

/// Why a board has begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reset {
    /// It has been switched on.
    Power,
    /// Its watchdog has bitten.
    Watchdog,
    /// The reset button, the host's DTR, a supply that was too low; or a boot loader
    /// has taken the reason away.
    Other,
}

/// What a board says of itself to the one that begins after a reset. A number that
/// is none of these is no mark: RAM has lost it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark(pub u16);

impl Mark {
    /// Nothing has moved since the board was switched on.
    pub const NONE: Mark = Mark(0);
    /// The board rests, at any position.
    pub const MOVED: Mark = Mark(0x69E1);
    /// A motor moves.
    pub const MOVING: Mark = Mark(0x1E96);
}

impl Reset {
    /// Whether the position is unknown after this reset, in view of the mark that
    /// RAM has kept.
    ///
    /// ```
    /// use stepwright_device::{Mark, Reset};
    /// assert!(!Reset::Power.doubts(Mark::NONE));
    /// assert!(Reset::Other.doubts(Mark::MOVING));
    /// ```
    pub fn doubts(self, mark: Mark) -> bool {
        match self {
            Reset::Watchdog => true,
            Reset::Other if mark == Mark::MOVED => true,
            _ => mark == Mark::MOVING,
        }
    }
}
