//! What is said while a file is played.

use std::fmt::Display;

/// In which form what is played is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayFormat {
    /// Positions each second, as stepper_h prints them.
    List,
    /// Every event: `time_us,motor,event,value,position`; of a board positions at each look.
    Csv,
    /// What became of each motor and cycle, once it is asked for.
    Json,
    /// Nothing is said.
    Silent,
}

/// Who is told what a player does, and may break it off.
pub trait PlayVoice {
    /// A line of what was asked for.
    fn result(&self, line: &dyn Display);

    /// A line for people.
    fn note(&self, line: &dyn Display);

    /// Whether somebody wants it to end. It is asked some hundred times a second.
    fn asked(&self) -> bool;
}
