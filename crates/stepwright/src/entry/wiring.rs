//! What the pins of entries mean to who plays them.

/// The bits of an entry's pins that mean a step and a turn of an axis, and how much time
/// what plays them needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wiring {
    /// STEP rises.
    pub step: u8,
    /// DIR is toggled.
    pub turn: u8,
    #[cfg(not(target_arch = "avr"))]
    prompt: bool,
}

impl Wiring {
    /// For step interrupts in assembly, which need time between two entries: no event comes
    /// sooner than [`LEAST`](super::LEAST) after a turn or a hold, and a few fast steps are joined with
    /// those that follow.
    pub const fn new(step: u8, turn: u8) -> Wiring {
        Wiring {
            step,
            turn,
            #[cfg(not(target_arch = "avr"))]
            prompt: false,
        }
    }

    /// For a player that needs no time between two entries, and takes waits to 2⁻¹⁶ ticks:
    /// none is made longer or rounded, and no steps are joined or grouped.
    #[cfg(not(target_arch = "avr"))]
    pub const fn prompt(self) -> Wiring {
        Wiring { prompt: true, ..self }
    }

    #[cfg(not(target_arch = "avr"))]
    pub(super) const fn is_prompt(self) -> bool {
        self.prompt
    }
}
