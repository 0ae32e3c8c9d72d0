//! The output while a file is played.

use std::fmt::Display;

/// The format of the output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayFormat {
    /// Positions each second, as stepper_h prints them.
    List,
    /// Every event: `time_us,motor,event,value,position`; for a real board, positions at each poll.
    Csv,
    /// The result of each motor and cycle, on request.
    Json,
    /// No output.
    Silent,
}

/// Receives the output of a player, and may interrupt it.
pub trait PlayVoice {
    /// Prints a line of the result.
    fn result(&self, line: &dyn Display);

    /// Prints a note for the user.
    fn note(&self, line: &dyn Display);

    /// Whether the player shall end. Called some hundred times a second.
    fn asked(&self) -> bool;
}

/// No output, and no interruption.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mute;

impl PlayVoice for Mute {
    fn result(&self, _: &dyn Display) {}
    fn note(&self, _: &dyn Display) {}
    fn asked(&self) -> bool {
        false
    }
}
