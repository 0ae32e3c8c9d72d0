//! What the pins of entries mean to their player.

use crate::format::Prompt;

/// The pin bits of an entry that mean a step and a turn of an axis, and how much time their player
/// needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wiring {
    /// STEP rises.
    pub step: u8,
    /// DIR is toggled.
    pub turn: u8,
    prompt: Prompt,
}

impl Wiring {
    /// For step interrupts in assembly, which need time between two entries: no event comes sooner
    /// than [`LEAST`](super::LEAST) after a turn or a hold, and a few fast steps are joined with
    /// those that follow.
    pub const fn new(step: u8, turn: u8) -> Wiring {
        Wiring { step, turn, prompt: Prompt::NO }
    }

    /// For a player that needs no time between two entries and takes waits to 2⁻¹⁶ ticks: no wait
    /// is lengthened or rounded, and no steps are joined or grouped. With the feature `compact` no
    /// player is prompt: the waits of its entries have 8 fractional bits.
    pub const fn prompt(self) -> Wiring {
        Wiring { prompt: Prompt::YES, ..self }
    }

    pub(super) const fn is_prompt(self) -> bool {
        self.prompt.is()
    }
}
