//! Whether a board knows its position after a reset.
//!
//! After a reset the board counts from 0 again. That is correct for a board that has just been
//! switched on, and for one that has not moved since. So a board keeps a [`Mark`] in a part of RAM
//! that no start-up code clears, where it outlasts every reset except a loss of power. The mark and
//! the reason of the reset decide:
//!
//! | the reset was | no mark | moved | moving |
//! | --- | --- | --- | --- |
//! | power-up | known | known | unknown |
//! | button, brown-out, or unknown | known | unknown | unknown |
//! | watchdog | unknown | unknown | unknown |
//!
//! Many boot loaders clear the register with the reason (MCUSR): then the mark alone decides. RAM
//! keeps its contents for some seconds without power, so the position of such a board is also
//! unknown after it was unplugged for a moment. After a longer loss of power no mark is left,
//! whether the board moved or not: the axes are at 0 at power-up. A chip that can't tell a
//! brown-out from power-up (RP2040, nRF51) reports power-up.

/// The reason why a board has started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reset {
    /// Power-up.
    Power,
    /// The watchdog.
    Watchdog,
    /// The reset button, the host's DTR, a low supply voltage, or a reason that a boot loader has
    /// cleared.
    Other,
}

/// The state of a board, kept for after a reset. A number that is none of these is no mark: RAM has
/// lost it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark(pub u16);

impl Mark {
    /// The board has not moved since power-up.
    pub const NONE: Mark = Mark(0);
    /// The board rests, and has moved.
    pub const MOVED: Mark = Mark(0x69E1);
    /// A motor moves.
    pub const MOVING: Mark = Mark(0x1E96);
}

/// A board's reason of its last reset, and RAM that outlasts every reset except a loss of power.
///
/// `()` has neither: each of its starts is a power-up.
pub trait ResetIo {
    /// The reason of the last reset. Called once.
    fn reset(&mut self) -> Reset;

    /// The last mark that was set, even before a reset. Anything if RAM has lost it, as it does
    /// without power.
    fn mark(&self) -> Mark;

    /// Sets the mark. After a reset during the call, `mark` MUST return the old mark or this one,
    /// or an invalid one.
    fn set_mark(&mut self, mark: Mark);

    /// Sets the mark of a board that has started. True if its position is unknown.
    fn begin(&mut self) -> bool {
        let doubts = self.reset().doubts(self.mark());
        self.set_mark(if doubts { Mark::MOVED } else { Mark::NONE });
        doubts
    }

    /// Sets the mark of a program whose axes move, or are about to, as `moves` says.
    #[inline(always)]
    fn note(&mut self, moves: impl FnOnce() -> bool) {
        let (moves, marked) = (moves(), self.mark() == Mark::MOVING);
        if moves != marked {
            self.set_mark(if moves { Mark::MOVING } else { Mark::MOVED });
        }
    }
}

impl ResetIo for () {
    fn reset(&mut self) -> Reset {
        Reset::Power
    }

    fn mark(&self) -> Mark {
        Mark::NONE
    }

    fn set_mark(&mut self, _: Mark) {}

    #[inline(always)]
    fn note(&mut self, _: impl FnOnce() -> bool) {}
}

impl Reset {
    /// Whether the position is unknown after this reset, with the mark that RAM has kept.
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
