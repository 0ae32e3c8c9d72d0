//! An observer that watches cycles on the virtual board, and may hold them up.

use std::ops::Range;

use stepwright::Ticks;
use stepwright_path::LivePath;

use crate::PlayError;
use stepwright_cyclefile::MOST;

/// A part of a file, and the time at which it begins.
pub struct PlayPart<'a> {
    /// `line`, `arc`, `path`, `home`, `moves` or `rest`.
    pub kind: &'static str,
    /// Its position in the file.
    pub at: Range<usize>,
    /// Ticks since the board was switched on.
    pub begin: u64,
    /// For a line or an arc, the path, and the ticks from the start of the part to that of the
    /// path.
    pub path: Option<(&'a LivePath, Ticks)>,
}

/// The answer of an onlooker to the player.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayAhead {
    /// Play up to this tick.
    On(u64),
    /// Brake the motors, and drop the rest. Returned once.
    Stop,
}

/// An observer of a player.
pub trait Onlooker {
    /// Called when a part begins.
    fn part(&mut self, part: PlayPart);

    /// Called when a motor has moved, with the tick and the motors' positions.
    fn at(&mut self, ticks: u64, positions: &[i64; MOST]);

    /// How far to play; `ticks` is the present.
    ///
    /// # Errors
    /// An error ends the playing.
    fn may(&mut self, ticks: u64) -> Result<PlayAhead, PlayError>;
}
